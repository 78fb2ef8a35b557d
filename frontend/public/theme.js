// A classic script: the page runs it before it paints.
try {
  const theme = localStorage.getItem('motionlab.theme');
  if (theme === 'light' || theme === 'dark') document.documentElement.dataset.theme = theme;
} catch {
  // Storage is forbidden: the system's theme stays.
}
