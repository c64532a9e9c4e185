#!/usr/bin/env node
// CNF-9: `fba-decoder.mjs INPUT`. Exit 0: accepted, 1: rejected (one JSON line on standard error), 2: usage, 3: files.

import { readFileSync } from 'node:fs';
import { Fault } from './bits.mjs';
import { decodeStream } from './stream.mjs';

const PIECE = 1 << 16;

function print(bytes) {
  let text = '';
  try {
    for (const record of decodeStream(bytes)) {
      text += `${JSON.stringify(record)}\n`;
      if (text.length > PIECE) {
        process.stdout.write(text);
        text = '';
      }
    }
    return 0;
  } catch (error) {
    if (!(error instanceof Fault)) throw error;
    console.error(JSON.stringify(error.report));
    return 1;
  } finally {
    process.stdout.write(text);
  }
}

function main([input, ...more]) {
  if (input === undefined || more.length > 0) {
    console.error('usage: fba-decoder.mjs INPUT');
    return 2;
  }
  let bytes;
  try {
    bytes = readFileSync(input);
  } catch (error) {
    console.error(`fba-decoder: ${error.message}`);
    return 3;
  }
  try {
    return print(bytes);
  } catch (error) {
    console.error(error);
    return 70;
  }
}

process.exitCode = main(process.argv.slice(2));
