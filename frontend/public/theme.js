// A classic script: the page runs it before it paints.
const theme = localStorage.getItem('motionlab.theme');
if (theme === 'light' || theme === 'dark') document.documentElement.dataset.theme = theme;
