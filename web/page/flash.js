// Writes the sketch into an Arduino Uno (ATmega328P) through its bootloader: STK500 version 1 (Atmel AVR061).

const STK = { ok: 0x10, insync: 0x14, end: 0x20, sync: 0x30, enter: 0x50, leave: 0x51, address: 0x55, program: 0x64, read: 0x74, signature: 0x75 };
const UNO = [0x1e, 0x95, 0x0f], PAGE_BYTES = 128, FLASH = 0x46;
// Optiboot of an Uno, and the older bootloader of its clones: their rates, and where they begin.
const BOOTLOADERS = [[115200, 0x7e00], [57600, 0x7800]];

// The bytes of an Intel HEX file, from address 0 on.
function parseHex(text) {
  const bytes = [];
  for (const line of text.split(/\r?\n/).filter(Boolean)) {
    const record = Uint8Array.from(line.slice(1).match(/../g) ?? [], pair => parseInt(pair, 16));
    const [size, high, low, type] = record;
    if (line[0] !== ":" || record.length !== size + 5 || record.reduce((sum, byte) => sum + byte, 0) % 256) throw new Error(`The sketch is damaged: ${line}`);
    if (type === 1) break;
    if (type !== 0) throw new Error(`The sketch has a record of type ${type}.`);
    record.slice(4, -1).forEach((byte, i) => { bytes[high * 256 + low + i] = byte; });
  }
  return Uint8Array.from(bytes, byte => byte ?? 0xff);
}

// The bootloader at an open port: bytes out and in.
class Bootloader {
  constructor(port) {
    [this.port, this.reader, this.writer, this.received] = [port, port.readable.getReader(), port.writable.getWriter(), []];
    this.ended = this.receive();
  }
  async receive() {
    try {
      for (let got; !(got = await this.reader.read()).done;) this.received.push(...got.value);
    } catch (error) {
      this.failure = error;
    }
  }
  async close() {
    await this.reader.cancel().catch(() => {});
    await this.ended;
    this.reader.releaseLock();
    this.writer.releaseLock();
  }
  // The answer to a command, of `size` bytes.
  async ask(command, size = 0, milliseconds = 1000) {
    this.received.length = 0;
    await this.writer.write(Uint8Array.from([...command, STK.end]));
    const end = performance.now() + milliseconds;
    while (this.received.length < size + 2) {
      if (this.failure || performance.now() > end) throw new Error("The board does not answer.");
      await new Promise(done => setTimeout(done, 2));
    }
    if (this.received[0] !== STK.insync || this.received[size + 1] !== STK.ok) throw new Error("The board does not answer as a bootloader.");
    return this.received.slice(1, size + 1);
  }
  // The line DTR resets the board, whose bootloader then listens for a second.
  async begin() {
    await this.port.setSignals({ dataTerminalReady: false, requestToSend: false });
    await new Promise(done => setTimeout(done, 100));
    await this.port.setSignals({ dataTerminalReady: true, requestToSend: true });
    await new Promise(done => setTimeout(done, 50));
    for (let tries = 12; ; tries--) {
      try {
        return await this.ask([STK.sync], 0, 120);
      } catch (error) {
        if (tries === 0 || this.failure) throw error;
      }
    }
  }
  at(page) { return this.ask([STK.address, page * PAGE_BYTES / 2 & 255, page * PAGE_BYTES / 2 >> 8]); }
}

// Writes the sketch and reads it back; `onProgress` hears how far it is, in words. Nothing is written into another chip.
async function flash(port, hex, onProgress) {
  const image = parseHex(hex), pages = Math.ceil(image.length / PAGE_BYTES);
  const page = i => Uint8Array.from({ length: PAGE_BYTES }, (_, k) => image[i * PAGE_BYTES + k] ?? 0xff);
  const size = [PAGE_BYTES >> 8, PAGE_BYTES & 255, FLASH];
  let missing;
  for (const [baudRate, room] of BOOTLOADERS) {
    await board.openPort(port, { baudRate });
    const boot = new Bootloader(port);
    let isWriting = false;
    try {
      onProgress(`looking for the bootloader at ${baudRate} baud`);
      try {
        await boot.begin();
      } catch (error) {
        missing = error;
        continue;
      }
      const signature = await boot.ask([STK.signature], 3);
      if (signature.join() !== UNO.join()) {
        throw new Error(`This is no Uno: its chip says ${signature.map(byte => byte.toString(16).padStart(2, "0")).join(" ")}, an ATmega328P 1e 95 0f. Nothing was written.`);
      }
      if (image.length > room) throw new Error(`The sketch has ${image.length} bytes, and the board room for ${room}. Nothing was written.`);
      await boot.ask([STK.enter]);
      isWriting = true;
      for (let i = 0; i < pages; i++) {
        onProgress(`writing ${i + 1} of ${pages} pages`);
        await boot.at(i);
        await boot.ask([STK.program, ...size, ...page(i)]);
      }
      for (let i = 0; i < pages; i++) {
        onProgress(`reading back ${i + 1} of ${pages} pages`);
        await boot.at(i);
        const found = await boot.ask([STK.read, ...size], PAGE_BYTES);
        if (found.join() !== page(i).join()) throw new Error(`Page ${i + 1} reads back otherwise than it was written.`);
      }
      await boot.ask([STK.leave]);
      return pages;
    } catch (error) {
      throw isWriting ? new Error(`${error.message} The sketch in the board is incomplete: flash it again.`) : error;
    } finally {
      await boot.close();
      await port.close().catch(() => {});
    }
  }
  throw new Error(`${missing.message} Nothing was written. Is it an Uno, with its own bootloader? Press its reset button, and try again.`);
}
