#!/bin/bash
# twin wheel: the paper's stiffnesses, a load-deflection curve, mistakes in one line.
set -eu
twin=$1
out=$2
rm -rf "$out"
mkdir -p "$out"

"$twin" wheel deflect --wheel amalia --load 42.1 --points 2 --out "$out/amalia" > "$out/deflect.txt"
/usr/bin/python3 - "$out/amalia/deflection.json" <<'PY'
import json, sys
curve = json.load(open(sys.argv[1]))["curve"]
assert len(curve) == 3 and curve[0]["deflection_m"] == 0.0, curve
# CalculiX: 2.063 mm (doc/validation.md); the paper's models differ by 8.9 % at most.
assert abs(curve[2]["deflection_m"] / 2.063e-3 - 1.0) < 0.089, curve
assert 0.4 < curve[1]["deflection_m"] / curve[2]["deflection_m"] < 0.6, curve
PY
grep -q "<svg" "$out/amalia/deflection.svg"
"$twin" wheel deflect --wheel cmu_smooth | grep -q "is rigid: no deflection"

# The ring of a short rim, so that the test is quick; the stiffnesses do not depend on what hangs on the rim.
sed 's/segments: 64/segments: 32/' "$(dirname "$0")/../../../config/wheels/amalia.yaml" > "$out/coarse.yaml"
"$twin" wheel calibrate --wheel "$out/coarse.yaml" --out "$out/coarse" > "$out/calibrate.txt"
/usr/bin/python3 - "$out/coarse/calibration.json" <<'PY'
import json, sys
rules = json.load(open(sys.argv[1]))["rules"]
beam = rules["beam"]
# E I / L: 147.5 N mm/deg at 64 segments, half of it at 32.
assert abs(beam["rim_joint_stiffness_n_mm_per_deg"] / 73.75 - 1.0) < 1e-3, beam
assert abs(beam["ring"][0]["loaded_over_elastica"] - 1.0) < 0.02, beam
plate = rules["plate"]["rim_joint_stiffness_n_mm_per_deg"] / beam["rim_joint_stiffness_n_mm_per_deg"]
assert abs(plate * 0.91 - 1.0) < 1e-9, plate
assert rules["printed"]["ring"][0]["loaded_over_elastica"] < 0.9, rules["printed"]
PY

refused() {  # refused TEXT ARGS...: exit 1 and one line on standard error that holds TEXT
  local text=$1
  shift
  local code=0
  "$twin" wheel "$@" 2> "$out/error.txt" > /dev/null || code=$?
  [ "$code" = 1 ] && [ "$(wc -l < "$out/error.txt")" = 1 ] && grep -q -- "$text" "$out/error.txt" ||
    { echo "exit $code for: $*"; cat "$out/error.txt"; exit 1; }
}
refused "rigid" calibrate --wheel cmu_smooth
refused "above 0 is needed" deflect --load -3
sed 's/segments: 64/segments: 63/' "$(dirname "$0")/../../../config/wheels/amalia.yaml" > "$out/odd.yaml"
refused "even number from 24 to 256" deflect --wheel "$out/odd.yaml"
