/** A worker that runs the kernel: one request after another. */

import { Engine } from './engine';
import type { Answer, Envelope, Reply, Request } from './tasks';

let engine: Engine | null = null;

function answer(request: Request): Answer {
  if (request.kind === 'open') {
    engine = new Engine(request.module, request.most);
    return null;
  }
  if (!engine) throw new Error('the module is not open');
  switch (request.kind) {
    case 'inputs':
      engine.take(request.inputs);
      return null;
    case 'run':
      return engine.run(request.run);
    case 'curves':
      return engine.curves(request.variant, request.columns, request.bins);
  }
}

/** Curves are handed over, not copied. */
function buffersOf(answer: Answer): ArrayBuffer[] {
  const curves = answer === null ? [] : 'curves' in answer ? answer.curves : answer;
  return curves.flatMap(({ minimum, maximum }) => [minimum.buffer, maximum.buffer]);
}

onmessage = ({ data: { id, request } }: MessageEvent<Envelope>) => {
  let reply: Reply;
  let buffers: ArrayBuffer[] = [];
  try {
    const result = answer(request);
    reply = { id, answer: result };
    buffers = buffersOf(result);
  } catch (error) {
    reply = { id, error: error instanceof Error ? error.message : String(error) };
  }
  postMessage(reply, { transfer: buffers });
};
