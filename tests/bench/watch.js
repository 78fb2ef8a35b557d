// Put before the page's own scripts: notes answers of what-ifs, and which canvases are drawn after.
(() => {
  const bench = {
    answers: 0,
    loops: 0, // answers of the server
    ownLoops: 0, // of a worker, of one variant
    asked: 0, // for lanes
    drawn: new Map(), // canvas to when, ms
    answered: 0, // ms
    last: 0,
    frames: 0,
    curves: 0,
    waiting: 0,
    presses: 0,
    arrivals: [],
  };
  window.bench = bench;

  // When which tick of the session had come; docs/stream.md has the header of a frame.
  const Socket = window.WebSocket;
  window.WebSocket = class extends Socket {
    constructor(...given) {
      super(...given);
      this.addEventListener('message', ({ data }) => {
        if (!(data instanceof ArrayBuffer) || data.byteLength < 24) return;
        const header = new DataView(data);
        const end = Number(header.getBigUint64(16, true)) + header.getUint32(12, true);
        bench.arrivals.push([performance.now(), end]);
      });
    }
  };

  const fetched = window.fetch;
  window.fetch = async (...given) => {
    const ofRun = String(given[0]).includes('/window?');
    if (ofRun) bench.waiting += 1;
    const response = await fetched(...given);
    if (ofRun) {
      const read = response.arrayBuffer.bind(response);
      response.arrayBuffer = async () => {
        const buffer = await read();
        bench.curves += 1;
        bench.waiting -= 1;
        return buffer;
      };
    }
    if (String(given[0]).endsWith('/loop')) bench.loops += 1;
    if (String(given[0]).endsWith('/whatif/lanes')) bench.asked += 1;
    const body = given[1]?.body;
    // What the page asks for once the controls rest is not an answer to an event.
    if (!String(given[0]).endsWith('/whatif') || JSON.parse(body).exact) return response;
    const read = response.arrayBuffer.bind(response);
    response.arrayBuffer = async () => {
      const buffer = await read();
      bench.answers += 1;
      bench.answered = performance.now();
      return buffer;
    };
    return response;
  };

  // Previews that the page computes: every variant's figures come from a worker.
  const Own = window.Worker;
  window.Worker = class extends Own {
    constructor(...given) {
      super(...given);
      this.addEventListener('message', ({ data }) => {
        if (!data.answer?.windows) return;
        bench.answers += 1;
        if (data.answer.loops) bench.ownLoops += 1;
        bench.answered = performance.now();
      });
    }
  };

  // Every plot clears its canvas before it draws.
  const { clearRect } = CanvasRenderingContext2D.prototype;
  CanvasRenderingContext2D.prototype.clearRect = function (...given) {
    bench.last = performance.now();
    bench.drawn.set(this.canvas, bench.last);
    bench.lastFrame = bench.frames;
    return clearRect.apply(this, given);
  };

  const count = () => {
    bench.frames += 1;
    requestAnimationFrame(count);
  };
  requestAnimationFrame(count);

  const shown = (canvas) => canvas.isConnected && canvas.clientWidth > 0;
  const frame = () => new Promise(requestAnimationFrame);
  // After the frame's script, layout and paint.
  const painted = async () => {
    await frame();
    await new Promise((resolve) => {
      const { port1, port2 } = new MessageChannel();
      port1.onmessage = resolve;
      port2.postMessage(null);
    });
  };

  const controlOf = (label) => document.querySelector(`input[aria-label="${label}"]`);
  /** Moves a slider about where it stood, and a field of a number by one key: up or down. */
  const move = (control, home, phase) => {
    if (control.type === 'range') {
      control.value = String(home + 0.1 * Math.sin(phase));
      control.dispatchEvent(new Event('input', { bubbles: true }));
      return;
    }
    const key = Math.sin(phase) > 0 ? 'ArrowUp' : 'ArrowDown';
    control.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
  };

  const asking = () => document.querySelector('[data-testid=margins][aria-busy=true]');

  /**
   * Moves a control `times` times; resolves to ms from each event until every plot, and until every margin is new,
   * which it waits for if `loops`.
   */
  bench.slide = async (label, times, loops = true) => {
    const slider = controlOf(label);
    // The overview is of the whole run, which is asked for once the controls rest.
    const canvases = [...document.querySelectorAll('canvas')].filter(
      (canvas) => shown(canvas) && !canvas.closest('[role=slider]'),
    );
    const home = slider.valueAsNumber;
    const taken = [];
    const margins = [];
    for (let i = 0; i < times; i++) {
      // Between two frames, at another phase each time.
      await frame();
      await new Promise((resolve) => setTimeout(resolve, (i * 7) % 16));
      const { answers, loops: before, ownLoops } = bench;
      const begin = performance.now();
      move(slider, home, (i + 1) * 2.4);
      const drawn = () =>
        bench.answers > answers &&
        canvases.every((canvas) => (bench.drawn.get(canvas) ?? 0) >= bench.answered);
      let [plots, margin] = [0, loops ? 0 : Infinity];
      while (!plots || !margin) {
        await painted();
        const now = performance.now() - begin;
        if (!plots && drawn()) plots = now;
        const own = bench.ownLoops > ownLoops; // of the variant that has changed
        if (!margin && (own || (bench.loops > before && !asking()))) margin = now;
        if (now > 10_000) throw new Error(`event ${i} without an answer`);
      }
      taken.push(plots);
      margins.push(margin);
    }
    slider.dispatchEvent(new Event('change', { bubbles: true }));
    return { taken, margins, plots: canvases.length };
  };

  /** Moves a slider in every frame for some ms; resolves to how many previews came, and events. */
  bench.drag = async (label, time) => {
    const slider = controlOf(label);
    const home = slider.valueAsNumber;
    const { answers } = bench;
    const begin = performance.now();
    let events = 0;
    while (performance.now() - begin < time) {
      move(slider, home, (events += 1) * 0.1);
      await frame();
    }
    slider.dispatchEvent(new Event('change', { bubbles: true }));
    return { previews: bench.answers - answers, events };
  };

  /** Presses a key that zooms or moves; resolves to ms and frames until all that it asks for has been drawn. */
  bench.press = async (key) => {
    const quiet = 60; // nothing is drawn any more
    // Between two frames, at another phase each time.
    await frame();
    await new Promise((resolve) => setTimeout(resolve, ((bench.presses += 1) * 7) % 16));
    const begin = performance.now();
    const { frames } = bench;
    Object.assign(bench, { last: begin, lastFrame: frames });
    document.body.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
    do {
      await painted();
      if (performance.now() - begin > 10_000) throw new Error(`${key} was not drawn`);
    } while (bench.waiting > 0 || performance.now() - bench.last < quiet);
    return { taken: bench.last - begin, frames: bench.lastFrame - frames };
  };

  /** Waits for captures of an armed trigger; resolves to the times of their triggers, s, and when each was on screen, ms. */
  bench.captured = async (times) => {
    const found = [];
    const began = performance.now();
    while (found.length < times) {
      await painted();
      const now = performance.now();
      const at = document.querySelector('.captures [aria-current=true]')?.innerText;
      if (at && found.at(-1)?.[0] !== Number(at)) found.push([Number(at), now]);
      if (now - began > 60_000) throw new Error(`${found.length} captures in a minute`);
    }
    return { found, arrivals: bench.arrivals };
  };

  /** Clicks on a run of the list; resolves to ms until its curves have come and all are drawn. */
  bench.open = async (name) => {
    const row = [...document.querySelectorAll('[role=row]')].find((each) =>
      each.textContent.includes(name),
    );
    bench.drawn.clear();
    bench.curves = 0;
    const begin = performance.now();
    row.click();
    for (;;) {
      await painted();
      const canvases = [...document.querySelectorAll('section[aria-label=Run] canvas')];
      // Plane and scopes are two questions.
      const come = bench.curves >= 2 && bench.waiting === 0;
      if (come && canvases.length > 2 && canvases.every((canvas) => bench.drawn.has(canvas))) break;
      if (performance.now() - begin > 10_000) throw new Error(`${name} was not drawn`);
    }
    await painted();
    return performance.now() - begin;
  };
})();
