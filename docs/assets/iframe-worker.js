// A page that is opened as a file may start no worker. The search then runs in a hidden frame.
(() => {
  if (location.protocol !== "file:") return;
  class FrameWorker extends EventTarget {
    constructor(url) {
      super();
      this.frame = document.createElement("iframe");
      this.frame.hidden = true;
      document.body.append(this.frame);
      const inner = this.frame.contentWindow;
      window.addEventListener("message", (event) => {
        if (event.source !== inner) return;
        const passed = new MessageEvent("message", { data: event.data });
        this.dispatchEvent(passed);
        if (this.onmessage) this.onmessage(passed);
      });
      this.ready = new Promise((resolve) => {
        inner.postMessage = (data) => window.dispatchEvent(
          new MessageEvent("message", { data, source: inner }));
        inner.importScripts = (...urls) => urls.reduce(
          (before, one) => before.then(() => load(inner.document, one)), Promise.resolve());
        load(inner.document, url).then(resolve);
      });
      this.inner = inner;
    }
    postMessage(data) {
      this.ready.then(() => this.inner.dispatchEvent(new MessageEvent("message", { data })));
    }
    terminate() {
      this.frame.remove();
    }
  }
  const load = (page, url) => new Promise((resolve) => {
    const script = page.createElement("script");
    script.src = new URL(url, location.href);
    script.onload = resolve;
    page.body.append(script);
  });
  window.Worker = FrameWorker;
})();
