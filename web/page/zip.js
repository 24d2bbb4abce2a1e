// One file of several, as they are (PKWARE, APPNOTE 6.3.10: stored entries).

const CRC = Uint32Array.from({ length: 256 }, (_, n) => Array.from({ length: 8 }).reduce(c => c & 1 ? c >>> 1 ^ 0xedb88320 : c >>> 1, n));
const crc32 = bytes => ~bytes.reduce((crc, byte) => crc >>> 8 ^ CRC[(crc ^ byte) & 255], ~0) >>> 0;

// Numbers of so many bytes each, little endian.
function fields(...pairs) {
  const bytes = [];
  for (const [size, value] of pairs) for (let i = 0; i < size; i++) bytes.push(Math.floor(value / 2 ** (8 * i)) & 255);
  return Uint8Array.from(bytes);
}

function zip(files, now = new Date()) {
  const time = now.getHours() << 11 | now.getMinutes() << 5 | now.getSeconds() >> 1;
  const date = now.getFullYear() - 1980 << 9 | now.getMonth() + 1 << 5 | now.getDate();
  const parts = [], central = [];
  let at = 0, length = 0;
  for (const { name, bytes } of files) {
    const text = new TextEncoder().encode(name);
    // Version 2.0, names in UTF-8, stored.
    const common = fields([2, 20], [2, 0x800], [2, 0], [2, time], [2, date], [4, crc32(bytes)], [4, bytes.length], [4, bytes.length], [2, text.length], [2, 0]);
    parts.push(fields([4, 0x04034b50]), common, text, bytes);
    central.push(fields([4, 0x02014b50], [2, 20]), common, fields([2, 0], [2, 0], [2, 0], [4, 0], [4, at]), text);
    at += 4 + common.length + text.length + bytes.length;
    length += 46 + text.length;
  }
  const end = fields([4, 0x06054b50], [4, 0], [2, files.length], [2, files.length], [4, length], [4, at], [2, 0]);
  return new Blob([...parts, ...central, end]);
}
