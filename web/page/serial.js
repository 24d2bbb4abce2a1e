// A board at a port of this computer (Web Serial): its bytes, and that it is gone or here again.

const NAMES = { 0x2341: "Arduino", 0x2a03: "Arduino", 0x1a86: "board with CH340", 0x10c4: "board with CP210x", 0x0403: "board with FTDI",
  0x303a: "ESP32", 0x2e8a: "Pico", 0x239a: "Adafruit board", 0x16c0: "Teensy" };

// A port that is back is opened when its rights are set, and other programs have looked at it.
const TRIES = 25, BETWEEN_MS = 200;
const now_s = () => (performance.timeOrigin + performance.now()) / 1e3;

const board = {
  // The port that is wanted, and its rate; `reader` while it is open.
  port: null, baudRate: 0, reader: null, isLost: false,
  // What happens, when: `bytes(now_s, bytes)`, `overflow(now_s)`, `opened(now_s)`, `lost(now_s)`, `trouble(text)`.
  on: null,
  isPossible: () => "serial" in navigator,

  // The browser asks which port; null if none was chosen. Needs a click.
  async choose() {
    try {
      return await navigator.serial.requestPort();
    } catch (error) {
      if (error.name === "NotFoundError") return null;
      throw error;
    }
  },
  nameOf(port) {
    const { usbVendorId: vendor, usbProductId: product } = port.getInfo();
    const hex = n => n.toString(16).padStart(4, "0");
    return vendor ? `${NAMES[vendor] ?? "USB device"} (${hex(vendor)}:${hex(product)})` : "serial port";
  },
  // Opens a port of the computer, with words for what goes wrong.
  async openPort(port, options) {
    try {
      await port.open(options);
    } catch (error) {
      throw new Error(error.name === "InvalidStateError" ? "This page has the port open already: load it again."
        : `The port cannot be opened (${error.message}). Another program or tab may hold it: close the serial monitor, the plotter and the slicer. `
          + "On Linux the port may be for members of a group: sudo usermod -aG dialout $USER, then log in again.");
    }
  },
  async open(port, baudRate, on) {
    await this.close();
    await this.openPort(port, { baudRate, bufferSize: 1 << 16 });
    Object.assign(this, { port, baudRate, on, isLost: false });
    on.opened(now_s());
    this.read(port);
  },
  // Reads until the port is closed or gone.
  async read(port) {
    while (port === this.port && port.readable) {
      const reader = this.reader = port.readable.getReader();
      try {
        for (let got; !(got = await reader.read()).done;) this.on.bytes(now_s(), got.value);
      } catch (error) {
        // A cable that is pulled ends it; a wrong baud rate and an overrun break the stream, and a new one goes on.
        if (error.name === "NetworkError") break;
        this.on.overflow(now_s());
      } finally {
        reader.releaseLock();
      }
    }
    if (port !== this.port) return;
    this.isLost = true;
    this.on.lost(now_s());
    await port.close().catch(() => {});
  },
  // A port was connected: reopens it if it is the lost one.
  async back(port) {
    if (!this.isLost || port !== this.port && this.nameOf(port) !== this.nameOf(this.port)) return;
    this.isLost = false;
    const { on, baudRate } = this;
    for (let tries = 1; on === this.on; tries++) {
      try {
        return await this.open(port, baudRate, on);
      } catch (error) {
        if (tries === TRIES) {
          Object.assign(this, { port, baudRate, on, isLost: true });
          return on.trouble(error.message);
        }
        Object.assign(this, { port, baudRate, on });
        await new Promise(done => setTimeout(done, BETWEEN_MS));
      }
    }
  },
  async close() {
    const { port, reader } = this;
    Object.assign(this, { port: null, reader: null, on: null, isLost: false });
    await reader?.cancel().catch(() => {});
    await port?.close().catch(() => {});
  },
};
navigator.serial?.addEventListener("connect", event => board.back(event.port ?? event.target));
