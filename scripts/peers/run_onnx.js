// SPDX-License-Identifier: Apache-2.0
// Measure one network in ONNX Runtime, in a process of its own; for scripts/bench-peers.
//
//     node run_onnx.js FOLDER THREADS RUNS SECONDS INPUTS COPIES
//
// FOLDER holds model.onnx and NAME.f32 for each of INPUTS, a JSON object of names and shapes. The outputs are
// compared with out0.f32 ... beside it: "difference" is the largest difference over the largest value. Times are
// those of one of COPIES layers in a chain.
// Prints one line of JSON. onnxruntime-node is looked for in NODE_PATH.
'use strict';
const fs = require('fs');
const path = require('path');
const ort = require('onnxruntime-node');

const WARM_UP = 3;
const [folder, threads, runs, seconds, inputs, copies] = process.argv.slice(2);

function floats(name) {
    const bytes = fs.readFileSync(path.join(folder, name + '.f32'));

    return new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
}

function difference(got, want) {
    let most = 0, largest = 0;

    for (let i = 0; i < want.length; i++) {
        most = Math.max(most, Math.abs(got[i] - want[i]));
        largest = Math.max(largest, Math.abs(want[i]));
    }
    return got.length === want.length ? most / largest : Infinity;
}

async function measure(session, feeds) {
    const ms = [];
    const start = performance.now();

    while (!ms.length || (ms.length < runs && performance.now() - start < 1e3 * seconds)) {
        const t = performance.now();

        await session.run(feeds);
        ms.push((performance.now() - t) / copies);
    }
    return ms.sort((a, b) => a - b);
}

async function main() {
    const session = await ort.InferenceSession.create(path.join(folder, 'model.onnx'), {
        executionProviders: ['cpu'], graphOptimizationLevel: 'all', intraOpNumThreads: Number(threads),
        interOpNumThreads: 1, executionMode: 'sequential', logSeverityLevel: 3,
    });
    const feeds = {};
    let out, worst = 0;

    for (const [name, shape] of Object.entries(JSON.parse(inputs)))
        feeds[name] = new ort.Tensor('float32', floats(name), shape);
    for (let i = 0; i < Math.min(WARM_UP, runs); i++)
        out = await session.run(feeds);
    for (const name of session.outputNames)
        worst = Math.max(worst, difference(out[name].data, floats(name)));
    const ms = await measure(session, feeds);
    console.log(JSON.stringify({
        median_ms: (ms[(ms.length - 1) >> 1] + ms[ms.length >> 1]) / 2, min_ms: ms[0], runs: ms.length,
        peak_rss_mb: process.resourceUsage().maxRSS / 1024, difference: worst,
        version: require('onnxruntime-node/package.json').version,
    }));
}

main().catch(e => {
    console.error(String(e.message || e));
    process.exit(1);
});
