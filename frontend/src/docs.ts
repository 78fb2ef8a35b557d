/** The page /docs: Swagger UI on this server's OpenAPI document. */

import bundle from 'swagger-ui-dist/swagger-ui-bundle.js?url';
import 'swagger-ui-dist/swagger-ui.css';

/** https://swagger.io/docs/open-source-tools/swagger-ui/usage/configuration/ */
declare function SwaggerUIBundle(options: {
  url: string;
  dom_id: string;
  deepLinking: boolean;
  displayRequestDuration: boolean;
  defaultModelsExpandDepth: number;
  validatorUrl: null;
}): unknown;

function chosenTheme(): string | null {
  try {
    return localStorage.getItem('motionlab.theme');
  } catch {
    return null; // Storage is forbidden.
  }
}

const theme = chosenTheme();
const dark = theme ? theme === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
document.documentElement.classList.toggle('dark-mode', dark);

// Not an import: the bundle is minified already, and building it again takes seconds.
const script = document.createElement('script');
script.src = bundle;
script.addEventListener('load', () => {
  SwaggerUIBundle({
    url: '/openapi.json',
    dom_id: '#api',
    deepLinking: true,
    displayRequestDuration: true,
    defaultModelsExpandDepth: 0,
    validatorUrl: null, // It is a service on the internet.
  });
});
document.head.append(script);
