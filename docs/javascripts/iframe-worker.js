// Browsers load no Worker from file://. In pages opened as files the search's runs in a hidden
// frame instead. (The plugin `offline` would fetch such a script from the network; it leaves that
// out where a script of this name is given.)
if (location.protocol === "file:") {
  window.IFrameWorker = window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      document.body.appendChild(frame);
      const page = frame.contentDocument;
      page.open();
      page.write("<body></body>");
      page.close();
      const scope = frame.contentWindow;
      const load = (source) =>
        new Promise((loaded, failed) => {
          const script = page.createElement("script");
          Object.assign(script, { src: source, onload: loaded, onerror: failed });
          page.body.appendChild(script);
        });
      scope.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
      scope.importScripts = (...sources) =>
        sources.reduce((before, next) => before.then(() => load(next)), Promise.resolve());
      const ready = load(url);
      this.postMessage = (data) =>
        ready.then(() => scope.dispatchEvent(new scope.MessageEvent("message", { data })));
    }
  };
}
