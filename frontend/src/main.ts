import { mount } from 'svelte';
import './app.css';
// Before the components, whose own rules win over it.
import './utilities.css';
import App from './App.svelte';
import './controls.css';
import './tables.css';
import './theme.css';
import { demo } from './app/demo/demo-mode';

/** The demo's part needs modules of this file: it is waited for, but not while they are loaded. */
async function start(): Promise<void> {
  const target = document.getElementById('app');
  if (!target) throw new Error('index.html has no #app');
  if (demo) (await import('./app/demo/demo-server')).startDemo(demo);
  mount(App, { target });
}

void start();
