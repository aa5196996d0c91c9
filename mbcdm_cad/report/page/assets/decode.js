// Reads the block of binary numbers that the scene's arrays point into.
(function (page) {
  "use strict";
  const KINDS = { uint16: Uint16Array, uint32: Uint32Array, int8: Int8Array };

  page.bytesOf = function (base64) {
    const text = atob(base64);
    const bytes = new Uint8Array(text.length);
    for (let k = 0; k < text.length; k += 1) bytes[k] = text.charCodeAt(k);
    return bytes.buffer;
  };

  page.arrayOf = function (buffer, place) {
    return new KINDS[place.type](buffer, place.start, place.count);
  };

  // Points stored as 16-bit steps of their box, as floats in mm.
  page.pointsOf = function (buffer, place) {
    const shorts = page.arrayOf(buffer, place);
    const points = new Float32Array(shorts.length);
    for (let k = 0; k < shorts.length; k += 1) points[k] = place.low[k % 3] + shorts[k] * place.step[k % 3];
    return points;
  };
})((window.drivePage = window.drivePage || {}));
