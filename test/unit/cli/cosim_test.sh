#!/bin/bash
# twin run --fidelity dem on a bed of some hundred grains: driven, towed, steered, T0-R0. Loads are carried, signs are
# those of physics, the same call gives the same bits, a run cut short goes on from its checkpoint.
set -eu
twin=$1
out=$2
rm -rf "$out"
mkdir -p "$out"
export WHEEL_TWIN_CACHE=$out/beds
settings() {  # settings NAME LENGTH WIDTH
  cat > "$out/$1.yaml" <<YAML
name: $1
bed: {length: $2, width: $3, depth: 0.05, periodic: true, fill_friction: 0.5}
grain_scale: 2.0
step_fraction: 0.4
start_x: 0.1
profile: {lowering_speed: 0.3, dwell: 0.0, ramp: 0.05, duration: 0.3, rest: 0.0}
YAML
}
settings amalia 0.26 0.12
settings t0_r0 0.3 0.16
run() { "$twin" run --fidelity dem --threads 1 "$@" > /dev/null; }
mean() { sed -n "s/.*\"$2\": \([-0-9.e]*\),*/\1/p" "$out/$1.json" | tail -1; }
holds() { awk "BEGIN { exit !($1) }" || { echo "not so: $1"; exit 1; }; }

run --dem "$out/amalia.yaml" --slip 0.4 --load 42.1 --out "$out/driven.bag"
run --dem "$out/amalia.yaml" --slip 0.4 --load 42.1 --out "$out/again.bag"
cmp "$out/driven.bag" "$out/again.bag"
run --dem "$out/amalia.yaml" --towed --load 42.1 --out "$out/towed.bag"
run --dem "$out/amalia.yaml" --slip 0.4 --load 42.1 --steering 15 --out "$out/left.bag"
run --dem "$out/t0_r0.yaml" --wheel t0_r0 --slip 0.4 --load 81.75 --out "$out/t0_r0.bag"
run --dem "$out/t0_r0.yaml" --wheel t0_r0 --slip 0.4 --load 81.75 --out "$out/t0_r0_again.bag"
cmp "$out/t0_r0.bag" "$out/t0_r0_again.bag"
run --dem "$out/amalia.yaml" --slip 0.4 --load 42.1 --steering -15 --out "$out/right.bag"
for name in driven towed left right t0_r0; do  # within what the slide's mass gains or loses over 0.15 s
  load=42.1
  [ $name = t0_r0 ] && load=81.75
  holds "$(mean $name normal_load_n) > 0.85 * $load && $(mean $name normal_load_n) < 1.15 * $load"
done
for name in driven t0_r0; do  # the drive gives more power than the pull takes; friction 0.5 and the grousers' thrust bound the pull
  radius=0.09
  [ $name = t0_r0 ] && radius=0.13
  holds "$(mean $name drive_torque_nm) > $(mean $name drawbar_pull_n) * $radius * (1 - $(mean $name slip))"
  holds "$(mean $name drawbar_pull_n) > 0 && $(mean $name drawbar_pull_n) < $(mean $name normal_load_n)"
done
holds "$(mean towed drawbar_pull_n) < 0 && $(mean towed slip) < 0"                              # pulled, it lags behind
# Uncoupled: no torque but what the wheel's inertia takes, a hundredth of the driven wheel's.
holds "$(mean towed drive_torque_nm) < 0.01 * $(mean driven drive_torque_nm)"
holds "$(mean towed drive_torque_nm) > -0.01 * $(mean driven drive_torque_nm)"
holds "$(mean left side_force_n) > $(mean right side_force_n) + 1"                              # to the side it is turned to

# A window that ends under the wheel is refused in one line.
sed 's/^start_x.*/&\nwindow: {behind: 0.05, ahead: 0.11}/' "$out/amalia.yaml" > "$out/narrow.yaml"
if run --dem "$out/narrow.yaml" --slip 0.4 --load 42.1 --out "$out/narrow.bag" 2> "$out/narrow.txt"; then exit 1; fi
grep -q "a window of 0.05 m behind and 0.11 m ahead of the hub is too small for wheel 'amalia'" "$out/narrow.txt"
[ "$(wc -l < "$out/narrow.txt")" -eq 1 ]
