import { mount } from 'svelte';
import './theme.css';
import './app.css';
import './controls.css';
import './tables.css';
import App from './App.svelte';

const target = document.getElementById('app');
if (!target) throw new Error('index.html has no #app');
mount(App, { target });
