// Keeps the page, so that it works without a network. The build fills in the two lists below.

const BUILD = /* build */;
const FILES = ['./', /* files */];

self.addEventListener('install', (event) => {
  const kept = caches.open(BUILD).then((cache) => cache.addAll(FILES));
  event.waitUntil(kept.then(() => self.skipWaiting()));
});

self.addEventListener('activate', (event) => {
  const others = caches.keys().then((all) => all.filter((name) => name !== BUILD));
  const gone = others.then((names) => Promise.all(names.map((name) => caches.delete(name))));
  event.waitUntil(gone.then(() => self.clients.claim()));
});

// All from what was kept: files of two builds are never mixed, and no request goes out.
self.addEventListener('fetch', (event) => {
  const kept = caches.open(BUILD).then((cache) => cache.match(event.request, { ignoreSearch: true }));
  event.respondWith(kept.then((found) => found ?? fetch(event.request)));
});
