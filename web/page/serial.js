// A board at a port of this computer (Web Serial): its bytes, and that it is gone or here again.

const NAMES = { 0x2341: "Arduino", 0x2a03: "Arduino", 0x1a86: "board with CH340", 0x10c4: "board with CP210x", 0x0403: "board with FTDI",
  0x303a: "ESP32", 0x2e8a: "Pico", 0x239a: "Adafruit board", 0x16c0: "Teensy" };

const board = {
  port: null, reader: null,
  // What happens: `bytes(bytes)`, `opened()`, `lost()`.
  on: { bytes() {}, opened() {}, lost() {} },
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
  async open(port, baudRate) {
    await this.close();
    try {
      await port.open({ baudRate, bufferSize: 1 << 16 });
    } catch (error) {
      throw new Error(error.name === "InvalidStateError" ? "The port is open in another tab: close it there."
        : `The port cannot be opened (${error.message}). Another program may hold it: close the serial monitor, the plotter and the slicer. `
          + "On Linux the port may be for members of a group: sudo usermod -aG dialout $USER, then log in again.");
    }
    this.port = port;
    this.baudRate = baudRate;
    this.on.opened();
    this.read(port);
  },
  // Reads until the port is closed or gone.
  async read(port) {
    while (port === this.port && port.readable) {
      this.reader = port.readable.getReader();
      try {
        for (let got; !(got = await this.reader.read()).done;) this.on.bytes(got.value);
      } catch (error) {
        // A wrong baud rate and an overrun break the stream, and a new one goes on; a cable that is pulled ends it.
        if (error.name === "NetworkError") break;
      } finally {
        this.reader.releaseLock();
      }
    }
    if (port === this.port) {
      this.on.lost();
      await port.close().catch(() => {});
    }
  },
  async close() {
    const { port } = this;
    this.port = null;
    await this.reader?.cancel().catch(() => {});
    await port?.close().catch(() => {});
  },
};
// The board that was lost is opened when it is here again.
navigator.serial?.addEventListener("connect", event => {
  const port = event.port ?? event.target;
  if (board.port && board.nameOf(port) === board.nameOf(board.port)) board.open(port, board.baudRate).catch(() => {});
});
