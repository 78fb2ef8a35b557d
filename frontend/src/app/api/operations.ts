/** Types of every call, from the generated schema: a path or field that is renamed does not compile. */

import type { paths } from './schema';
import type { Changes, Scenario, Trajectory } from './types';

type Root = '/api/v1';
export type Method = 'get' | 'put' | 'post' | 'delete' | 'patch';

type At<P extends keyof paths, M extends Method> = Extract<paths[P][M], { responses: object }>;

/** Paths below the root that have a method. */
export type PathOf<M extends Method> = {
  [P in keyof paths]: P extends `${Root}${infer Rest}`
    ? [At<P, M>] extends [never]
      ? never
      : Rest
    : never;
}[keyof paths];

export type Operation<M extends Method, P extends PathOf<M>> = At<`${Root}${P}` & keyof paths, M>;

export interface ScenarioRequest {
  scenario?: string | Scenario;
  set?: Changes;
}

/** What is answered as JSON; undefined where nothing or something else is. */
export type Answer<O> = O extends { responses: infer R }
  ? {
      [S in keyof R]: S extends 200 | 201 | 202
        ? R[S] extends { content: { 'application/json': infer C } }
          ? C
          : undefined
        : never;
    }[keyof R]
  : never;

/** All fields have defaults, or the server says what is missing. */
type Loose<T> = T extends readonly (infer I)[]
  ? readonly Loose<I>[]
  : T extends object
    ? { readonly [K in keyof T]?: Loose<T[K]> }
    : T;

/** Scenarios and trajectories are read through paths: their tables are not spelt out here. */
type Plain<B> = B extends { kind: string }
  ? Trajectory
  : Loose<Omit<B, 'scenario' | 'set' | 'trajectory'>> &
      ('scenario' extends keyof B ? ScenarioRequest : unknown) &
      ('trajectory' extends keyof B ? { trajectory: Trajectory } : unknown);

type Body<O> = O extends { requestBody?: infer R } ? BodyOf<NonNullable<R>> : undefined;
type BodyOf<R> = [R] extends [never]
  ? undefined
  : R extends { content: { 'application/json': infer B } }
    ? Plain<B>
    : string | Blob;

/** The JSON body of a POST. */
export type RequestOf<P extends PathOf<'post'>> = Body<Operation<'post', P>>;

type Given<K extends string, T> = [Exclude<T, undefined>] extends [never]
  ? unknown
  : undefined extends T
    ? { [key in K]?: T }
    : { [key in K]: T };

/** The header without which a call is refused; others are left out. */
type Lease<H> = [H] extends [never]
  ? unknown
  : [H] extends [{ Lease: string }]
    ? { header: H }
    : unknown;

/** What a call is given: parts of its path, its query, its headers and its body. */
export type Options<O> = O extends {
  parameters: { path?: infer P; query?: infer Q; header?: infer H };
}
  ? Given<'path', P> & Given<'query', Q> & Lease<H> & Given<'body', Body<O>>
  : never;
