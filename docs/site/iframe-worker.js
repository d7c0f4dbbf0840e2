// Lets the search work in pages that are opened from the disk: browsers refuse workers there, so a hidden frame does the work
// of one. Loaded by the theme as its polyfill of this name, in place of one from the network.
window.IFrameWorker = class extends EventTarget {
  constructor(url) {
    super();
    this.onmessage = null;
    this.frame = document.createElement("iframe");
    this.frame.hidden = true;
    document.body.appendChild(this.frame);
    const inside = this.frame.contentWindow;
    inside.answer = data => {
      const message = new MessageEvent("message", {data});
      this.dispatchEvent(message);
      if (this.onmessage) this.onmessage(message);
    };
    inside.document.open();
    inside.document.write(`<html><body><script>
      postMessage = answer;
      importScripts = (...urls) => urls.reduce((before, url) => before.then(() => new Promise((done, failed) => {
        const script = document.createElement("script");
        script.src = url, script.onload = done, script.onerror = failed;
        document.body.appendChild(script);
      })), Promise.resolve());
      document.currentScript.remove();
    <\/script><script src="${url}"><\/script></body></html>`);
    inside.document.close();
    this.loaded = new Promise(done => { inside.addEventListener("load", done); });
  }

  postMessage(data) {
    this.loaded.then(() => this.frame.contentWindow.dispatchEvent(new MessageEvent("message", {data})));
  }

  terminate() {
    this.frame.remove();
  }
};
if (location.protocol === "file:") window.Worker = window.IFrameWorker;
