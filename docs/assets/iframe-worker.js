/* A page that is opened as a file may start no worker, and the search runs in one: there, it runs in a hidden frame.
   The search asks for IFrameWorker, to know where its languages lie. */
if (location.protocol === "file:")
  window.Worker = window.IFrameWorker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      this.waiting = [];
      frame.addEventListener("load", () => this.started(frame.contentWindow, url), { once: true });
      document.documentElement.appendChild(frame);
      this.frame = frame;
    }

    started(inside, url) {
      inside.importScripts = (...scripts) =>
        scripts.reduce((before, one) => before.then(() => this.loaded(inside, one)), Promise.resolve());
      inside.postMessage = (data) => {
        const event = new MessageEvent("message", { data });
        this.dispatchEvent(event);
        if (this.onmessage) this.onmessage(event);
      };
      this.loaded(inside, url).then(() => {
        this.inside = inside;
        this.waiting.forEach((data) => this.postMessage(data));
      });
    }

    loaded(inside, url) {
      return new Promise((done, failed) => {
        const script = inside.document.createElement("script");
        script.src = new URL(url, document.baseURI);
        script.onload = done;
        script.onerror = failed;
        inside.document.head.appendChild(script);
      });
    }

    postMessage(data) {
      if (this.inside) this.inside.dispatchEvent(new MessageEvent("message", { data }));
      else this.waiting.push(data);
    }

    terminate() {
      this.frame.remove();
    }
  };
