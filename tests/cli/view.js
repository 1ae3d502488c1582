// SPDX-License-Identifier: Apache-2.0
// Runs inside a report's page: draws its first frame as large as the CPU did, and compares the two.
// The page has the CPU's images as #joint and #hand beside; the line in #result is what the test reads.
addEventListener("load", () => {
    const canvas = document.querySelector("#view canvas"), input = (name) => document.querySelector(`#view .${name}`);
    const [joint, hand] = ["joint", "hand"].map((id) => document.getElementById(id));
    const W = joint.naturalWidth, H = joint.naturalHeight;
    const pixels = (source) => {
        const to = Object.assign(document.createElement("canvas"), { width: W, height: H }).getContext("2d");
        to.drawImage(source, 0, 0);
        return to.getImageData(0, 0, W, H).data;
    };
    // At once, so that all is done when the page counts as loaded, and as what was drawn can be read until it is shown.
    window.requestAnimationFrame = (then) => then();
    const drawn = (change) => { change(); return pixels(canvas); };
    const psnr = (a, b) => {
        let sum = 0;
        for (let i = 0; i < a.length; i++)
            sum += i % 4 === 3 ? 0 : (a[i] - b[i]) ** 2;
        return 10 * Math.log10(255 ** 2 * 3 * W * H / sum);
    };
    const differ = (a, b, i) => Math.max(...[0, 1, 2].map((k) => Math.abs(a[4 * i + k] - b[4 * i + k])));
    const nearHand = (of, i) => {
        for (let y = -1; y <= 1; y++)
            for (let x = -1; x <= 1; x++)
                for (let k = 0; k < 3; k++)
                    if (of[4 * (i + y * W + x) + k] > 0)
                        return true;
        return false;
    };
    const toggle = (name) => () => input(name).click();
    const whole = drawn(() => {
        canvas.style.width = `${W}px`;
        dispatchEvent(new Event("resize"));
    });
    const handless = drawn(toggle("hand")), cpuHand = pixels(hand);
    drawn(toggle("hand"));
    const surface = drawn(toggle("surface"));
    let changed = 0, strangers = 0, shown = 0;
    for (let i = 0; i < W * H; i++) {
        const d = differ(whole, handless, i);
        changed += d > 8;
        strangers += d > 2 && !nearHand(cpuHand, i);
        shown += differ(surface, new Uint8ClampedArray(4 * W * H), i) > 30;
    }
    document.getElementById("result").textContent = `size ${canvas.width} ${canvas.height} psnr ` +
        `${psnr(whole, pixels(joint)).toFixed(2)} changed ${changed} strangers ${strangers} surface ${shown}`;
});
