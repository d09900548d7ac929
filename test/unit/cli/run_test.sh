#!/bin/bash
# twin run: writes bag and summary, the same seed gives the same bytes, mistakes give one line and no file.
set -eu
twin=$1
out=$2
rm -rf "$out"
mkdir -p "$out"
cat > "$out/wheel.yaml" <<'YAML'
{name: test_wheel, radius: 0.09, width: 0.07, grousers: 24, grouser_height: 0.007, stiffness: 9000.0}
YAML
run() { "$twin" run --wheel "$out/wheel.yaml" --travel 0.02 "$@"; }

run --slip 0.3 --seed 5 --out "$out/a.bag" > "$out/a.txt"
run --slip 0.3 --seed 5 --out "$out/b.bag" > /dev/null
run --slip 0.3 --seed 6 --out "$out/c.bag" > /dev/null
cmp "$out/a.bag" "$out/b.bag"
! cmp -s "$out/a.bag" "$out/c.bag"
grep -q "drawbar pull" "$out/a.txt"
grep -q '"drawbar_pull_n"' "$out/a.json"

refused() {  # refused TEXT ARGS...: exit 1, one line on standard error that holds TEXT, no bag
  local text=$1
  shift
  local code=0
  run "$@" --out "$out/bad.bag" 2> "$out/error.txt" > /dev/null || code=$?
  [ "$code" = 1 ] || { echo "exit $code for: $*"; exit 1; }
  [ "$(wc -l < "$out/error.txt")" = 1 ] && grep -q -- "$text" "$out/error.txt" || { cat "$out/error.txt"; exit 1; }
  [ ! -e "$out/bad.bag" ]
}
refused "steering angle 30 degrees" --steering 30
refused "slip 1.5" --slip 1.5
refused "no such file; known" --soil cheese
refused "has no parameter" --effect slide_friction:force=1.0
refused "not a number" --effect slide_friction:coulomb_force=much
refused "below its height at first touch" --load 100000
code=0
"$twin" run --slip 2> /dev/null > /dev/null || code=$?
[ "$code" = 2 ]

cat > "$out/experiment.yaml" <<'YAML'
schema: 1
name: two_runs
wheel: {name: test_wheel, radius: 0.09, width: 0.07, grousers: 24, grouser_height: 0.007, stiffness: 9000.0}
soil: {name: sand, k_c: 1370.0, k_phi: 814000.0, n: 1.0, c: 0.0, phi: 0.698, K: 0.022, c1: 0.2, c2: 0.15, gamma: 0.3}
runs:
- {bag: run_00.bag, role: reference, slip: 0.0, load: 42.1, wheel_speed: 0.2859, steering_angle: 0.0}
- {bag: run_01.bag, role: measured, slip: 0.3, load: 61.7, wheel_speed: 0.2859, steering_angle: 0.1}
YAML
"$twin" run --experiment "$out/experiment.yaml" --travel 0.02 --out "$out/virtual" > /dev/null
[ -s "$out/virtual/run_00.bag" ] && [ -s "$out/virtual/run_01.json" ] && [ -s "$out/virtual/experiment.yaml" ]
