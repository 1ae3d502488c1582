#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The view in the page of a HOGS run, in headless Chromium with its own software WebGL: its first frame is what the CPU
# draws, and hiding the hand changes pixels of the hand alone. Skipped where there is no Chromium.
set -e
chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome) || exit 77
palmar=$PWD/palmar
script=$(cd "${srcdir:?}" && pwd)/tests/cli/view.js
rm -rf tests/cli/view.dir
mkdir -p tests/cli/view.dir
cd tests/cli/view.dir

"$palmar" synth --preset hogs --frames 32 --seed 5 --out data >synth.log 2>&1
"$palmar" train --quiet --config hogs-cpu --data data --out run --set model.gaussians=200 --set data.iterations=20 \
    --set data.pose_epochs=0 >train.log
"$palmar" report run --view 2
"$palmar" predict run data --quiet --out frames
first=frames/$(sed -n 's/.*<figcaption>Frame 0, \([^:]*\):.*/\1/p' run/report.html)
nonce=$(sed -n "s/.*script-src 'nonce-\([0-9a-f]*\)'.*/\1/p" run/report.html)

# The page, and behind it the CPU's images and the script that compares: it may run, as it knows the page's number.
{
    cat run/report.html
    for name in joint hand; do
        printf '<img id=%s src="data:image/png;base64,%s">' "$name" "$(base64 -w 0 "$first/$name.png")"
    done
    printf '<p id=result></p><script nonce=%s>' "$nonce"
    cat "$script"
    printf '</script>'
} >compare.html
"$chromium" --headless --no-sandbox --no-first-run --disable-background-networking --use-angle=swiftshader \
    --enable-unsafe-swiftshader --user-data-dir="$PWD/profile" --dump-dom "file://$PWD/compare.html" >dom.html 2>chromium.log
rm -rf profile
result=$(sed -n 's/.*<p id="result">\([^<]*\)<.*/\1/p' dom.html)
echo "$result"
echo "$result" | awk '$1 == "size" && $2 == 320 && $3 == 240 && $5 >= 25 && $7 > 50 && $9 == 0 { ok = 1 } END { exit !ok }'
