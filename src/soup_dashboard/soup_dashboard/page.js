// Draws the warehouse. The server calls warehouse.floor once a world and warehouse.frame a few times a second.
const warehouse = (() => {
  const FREE = 0, PENALISED = 5; // BotState
  const LOST_MS = 3000; // without news for so long, the page says so
  let floor = null, frame = null, due = false, chosen = 0, heard = performance.now();
  const element = (id) => document.getElementById(id);

  function text(id, value) {
    const target = element(id);
    if (target && target.textContent !== value) target.textContent = value;
  }

  // metres of frame `map` (y up) to pixels
  function scale(canvas) {
    const margin = 14;
    const k = Math.min((canvas.clientWidth - 2 * margin) / floor.width, (canvas.clientHeight - 2 * margin) / floor.height);
    const left = (canvas.clientWidth - k * floor.width) / 2, bottom = (canvas.clientHeight + k * floor.height) / 2;
    return { k, x: (x) => left + k * x, y: (y) => bottom - k * y };
  }

  function disc(c, x, y, r, colour) {
    c.fillStyle = colour;
    c.beginPath();
    c.arc(x, y, r, 0, 2 * Math.PI);
    c.fill();
  }

  function shade(tiles) {
    const f = Math.min(1, tiles / floor.capacity);
    return `rgb(${58 + 182 * f}, ${50 + 130 * f}, ${38 + 52 * f})`;
  }

  function draw() {
    due = false;
    const canvas = element("floor");
    if (!canvas || !floor) return;
    const ratio = window.devicePixelRatio || 1;
    const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const c = canvas.getContext("2d");
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
    const s = scale(canvas);
    c.fillStyle = "#1b2027";
    c.fillRect(s.x(0), s.y(floor.height), s.k * floor.width, s.k * floor.height);
    c.fillStyle = "#2b333c";
    floor.spots.x.forEach((x, i) => c.fillRect(s.x(x) - 1, s.y(floor.spots.y[i]) - 1, 2, 2));
    drawStations(c, s);
    if (frame && frame.buckets) drawBuckets(c, s, false);
    if (frame && frame.bots) drawBots(c, s);
    if (frame && frame.buckets) drawBuckets(c, s, true);
  }

  function drawStations(c, s) {
    const half = Math.max(6, 1.8 * s.k * floor.bot_radius);
    floor.stations.x.forEach((x, i) => {
      const px = s.x(x), py = s.y(floor.stations.y[i]);
      c.fillStyle = i < floor.word_stations ? "#37c48b" : "#c586e8";
      c.globalAlpha = frame && frame.stations[i] && frame.stations[i].bot >= 0 ? 0.9 : 0.4;
      c.fillRect(px - half, py - half, 2 * half, 2 * half);
      c.globalAlpha = 1;
      if (i === chosen) {
        c.strokeStyle = "#ffffff";
        c.lineWidth = 1.5;
        c.strokeRect(px - half - 2, py - half - 2, 2 * half + 4, 2 * half + 4);
      }
    });
  }

  // bots pass under resting buckets; a carried one rides on its bot, so it is drawn smaller and last
  function drawBuckets(c, s, carried) {
    const b = frame.buckets, r = Math.max(2, s.k * floor.bucket_radius) * (carried ? 0.6 : 1);
    b.x.forEach((x, i) => {
      if (b.bot[i] >= 0 === carried) disc(c, s.x(x), s.y(b.y[i]), r, shade(b.tiles[i]));
    });
  }

  function drawBots(c, s) {
    const b = frame.bots, r = Math.max(3.5, s.k * floor.bot_radius);
    b.x.forEach((x, i) => {
      const px = s.x(x), py = s.y(b.y[i]), state = b.state[i];
      disc(c, px, py, r, state === PENALISED ? "#ff5252" : state === FREE ? "#7d8794" : "#4d9fff");
      c.strokeStyle = "#ffffff";
      c.lineWidth = 1.5;
      c.beginPath();
      c.moveTo(px + 0.6 * r * Math.cos(b.heading[i]), py - 0.6 * r * Math.sin(b.heading[i]));
      c.lineTo(px + 1.5 * r * Math.cos(b.heading[i]), py - 1.5 * r * Math.sin(b.heading[i]));
      c.stroke();
    });
  }

  function row(table, cells) {
    const line = table.insertRow();
    for (const cell of cells) line.insertCell().textContent = cell;
    return line;
  }

  function refill(id) {
    const target = element(id);
    target.replaceChildren();
    return target;
  }

  function tell() {
    if (!frame || !element("figures")) return;
    text("clock", `${frame.time.toLocaleString("en", { minimumFractionDigits: 1, maximumFractionDigits: 1 })} s simulated`);
    const figures = refill("figures");
    for (const [key, words, value, unit] of frame.figures) {
      row(figures, [words, `${value} ${unit}`]).className = key === "violations" && value !== "0" ? "broken" : "";
    }
    const completed = refill("completed");
    for (const [time, station, word] of frame.completed) row(completed, [word, `station ${station}`, `${time.toFixed(1)} s`]);
    tellStation();
  }

  function tellStation() {
    const open = refill("open"), station = frame && frame.stations[chosen];
    if (!station) return;
    const line = () => open.appendChild(document.createElement("div"));
    for (const [word, marks] of station.words || []) {
      const target = line();
      [...word].forEach((letter, i) => {
        target.appendChild(document.createElement(marks[i] ? "b" : "span")).textContent = letter;
      });
    }
    for (const [tile, count] of station.bundles || []) line().textContent = `${tile} × ${count}`;
    if (!open.childElementCount) line().textContent = "nothing open";
  }

  function choose(station) {
    chosen = station;
    element("station").value = station;
    tellStation();
    later();
  }

  function fillChoice() {
    const choice = refill("station");
    floor.stations.x.forEach((_, i) => choice.add(new Option(`${i} (${i < floor.word_stations ? "words" : "letters"})`, i)));
    chosen = 0;
    choice.onchange = () => choose(Number(choice.value));
    element("floor").onclick = (event) => {
      const s = scale(event.target);
      const far = floor.stations.x.map((x, i) => Math.hypot(s.x(x) - event.offsetX, s.y(floor.stations.y[i]) - event.offsetY));
      const nearest = far.indexOf(Math.min(...far));
      if (far[nearest] < 24) choose(nearest);
    };
  }

  function later() {
    if (!due) requestAnimationFrame(draw);
    due = true;
  }

  function look() {
    const quiet = performance.now() - heard;
    const news = quiet > LOST_MS ? `no news for ${Math.round(quiet / 1000)} s` : frame ? frame.notice : "";
    text("news", floor ? news : "waits for the world");
  }

  window.addEventListener("resize", later);
  setInterval(look, 500);
  return {
    floor(given) {
      floor = given;
      frame = null;
      if (!floor) return;
      text("name", floor.name);
      fillChoice();
      later();
    },
    frame(given) {
      frame = given;
      heard = performance.now();
      look();
      tell();
      later();
    },
  };
})();
