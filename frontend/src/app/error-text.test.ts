import { describe, expect, it } from 'vitest';
import { ApiError, UNREACHABLE } from './api/client';
import { commandText, fileErrorText, errorText } from './error-text';

function refused(...errors: { loc: string; message: string; value?: unknown }[]): ApiError {
  return new ApiError({ title: 'Refused', status: 422, detail: '', errors });
}

describe('a scenario file', () => {
  it('is named, with where it cannot be read', () => {
    const message =
      "is not TOML: Expected '=' after a key in a key/value pair (at line 3, column 7)";
    expect(fileErrorText('a.toml', refused({ loc: 'body', message }))).toBe(
      "a.toml cannot be read: it is not TOML: Expected '=' after a key in a key/value pair " +
        '(at line 3, column 7).',
    );
    const picture = 'is not UTF-8 text: invalid start byte at byte 0';
    expect(fileErrorText('b.png', refused({ loc: 'body', message: picture }))).toBe(
      'b.png cannot be read: it is not UTF-8 text: invalid start byte at byte 0.',
    );
    const deep = refused({ loc: 'body', message: 'is nested too deeply' });
    expect(fileErrorText('c.toml', deep)).toBe('c.toml cannot be read: it is nested too deeply.');
  });

  it('is named with the values that are refused', () => {
    const error = refused({ loc: 'variants.B.controller.x.k_p', message: 'must be a number' });
    expect(fileErrorText('a.toml', error)).toBe(
      'a.toml was not opened.\nB k_p x: Must be a number.',
    );
    expect(fileErrorText('a.toml', new Error('The server does not answer.'))).toBe(
      'a.toml was not opened. The server does not answer.',
    );
  });
});

it('writes units as people do', () => {
  const detail = 'y needs 3.1 m/s^2 at 0.2 s, 4 um off';
  const error = new ApiError({ title: 'Infeasible', status: 422, detail, errors: [] });
  expect(errorText(error)).toBe('y needs 3.1 m/s² at 0.2 s, 4 µm off');
});

describe('a command', () => {
  const failure = (status: number) =>
    new ApiError({ title: '', status, detail: 'The server does not answer.', errors: [] });

  it('without an answer is named, as it is not sent again', () => {
    expect(commandText('Pause', failure(UNREACHABLE))).toBe(
      'Pause was not answered, and is not sent again. The server does not answer.',
    );
  });

  it('that is refused says why', () => {
    expect(commandText('Pause', failure(409))).toBe('The server does not answer.');
  });
});
