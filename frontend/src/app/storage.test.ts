import { afterEach, describe, expect, it, vi } from 'vitest';
import { listOf, load, nullOr, oneOf, partOf, recordOf } from './storage';

function keep(text: string): void {
  vi.stubGlobal('localStorage', { getItem: () => text });
}

afterEach(() => vi.unstubAllGlobals());

describe('load', () => {
  it('returns what was kept', () => {
    keep('{"x":"3","y":"4"}');
    expect(load('push', { x: '2', y: '2' })).toEqual({ x: '3', y: '4' });
    keep('{"anything":1}');
    expect(load('draft', {})).toEqual({ anything: 1 });
    expect(load('session', null)).toEqual({ anything: 1 });
  });

  it.each(['', '{not', 'null', '5', '[1]', '"text"', '{"x":5,"y":"1"}', '{"x":"1"}'])(
    'returns the fallback where %s was kept',
    (text) => {
      keep(text);
      expect(load('push', { x: '2', y: '2' })).toEqual({ x: '2', y: '2' });
    },
  );

  const FORM = {
    by: oneOf('range', 'values'),
    fields: listOf({ path: '' }),
    set: recordOf(0),
    part: partOf({ pair: [0, 0], limit: nullOr(0) }),
  };

  it.each(['{}', '{"pair":[1,2],"limit":null}', '{"limit":3,"other":[]}'])(
    'returns a nested value with the part %s',
    (part) => {
      const text = `{"by":"range","fields":[{"path":"seed"}],"set":{"a":1},"part":${part}}`;
      keep(text);
      expect(load('sweep', null, FORM)).toEqual(JSON.parse(text));
    },
  );

  it.each([
    '{"by":"other","fields":[],"set":{},"part":{}}',
    '{"by":"range","fields":[5],"set":{},"part":{}}',
    '{"by":"range","fields":[null],"set":{},"part":{}}',
    '{"by":"range","fields":[{"path":5}],"set":{},"part":{}}',
    '{"by":"range","fields":[],"set":{"a":null},"part":{}}',
    '{"by":"range","fields":[],"set":[],"part":{}}',
    '{"by":"range","fields":[],"set":{},"part":{"pair":[1]}}',
    '{"by":"range","fields":[],"set":{},"part":{"limit":"3"}}',
  ])('drops %s', (text) => {
    keep(text);
    expect(load('sweep', null, FORM)).toBeNull();
  });
});
