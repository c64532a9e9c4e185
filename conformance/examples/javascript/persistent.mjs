#!/usr/bin/env node
// CNF-10: asked for many vectors, one JSON object per line; every question has one answer with its seq and type.

import { readFileSync } from 'node:fs';
import { createInterface } from 'node:readline';
import { Fault } from './bits.mjs';
import { decodeStream } from './stream.mjs';

function decode(input) {
  let output = '';
  try {
    for (const record of decodeStream(readFileSync(input))) output += `${JSON.stringify(record)}\n`;
    return { status: 'accepted', output };
  } catch (error) {
    // Anything else ends this process: the runner sees a crash, and starts another one.
    if (!(error instanceof Fault)) throw error;
    return { status: 'rejected', error: error.report, output };
  }
}

const ANSWERS = {
  hello: (question) => ({ protocol: question.protocol, version: 1, tools: ['fba', 'bap'] }),
  decode: (question) => decode(question.input),
  bye: () => ({}),
};

const lines = createInterface({ input: process.stdin });
lines.on('line', (line) => {
  const { seq, type, ...question } = JSON.parse(line);
  process.stdout.write(`${JSON.stringify({ seq, type, ...ANSWERS[type](question) })}\n`);
  if (type === 'bye') process.stdin.destroy();
});
