// The catalogue of effects, one function a file. A new effect is one new file, one line here and one in
// catalogue.cpp.
#pragma once

#include <string>
#include <vector>

#include "effects/effect.h"

namespace wheel_twin::effects {

EffectType ft_bias();
EffectType ft_drift();
EffectType ft_thermal();
EffectType ft_misalignment();
EffectType ft_gain();
EffectType ft_crosstalk();
EffectType draw_wire_offset();
EffectType draw_wire_scale();
EffectType draw_wire_jump();
EffectType draw_wire_drift();
EffectType clock_skew();
EffectType carriage_speed_error();
EffectType dead_weight_error();
EffectType slide_friction();
EffectType rig_compliance();
EffectType bed_tilt();
EffectType steering_misalignment();
EffectType motor_drag();
EffectType wheel_eccentricity();
EffectType soft_spoke();
EffectType wheel_flexing_resistance();
EffectType slip_sinkage();
EffectType slip_loosening();
EffectType bulldozing();
EffectType soil_cohesion();
EffectType density_gradient();
EffectType multi_pass();
EffectType hard_layer();
EffectType buried_rock();

/// All effects, in the order above.
const std::vector<EffectType>& catalogue();

/// Throws Error with the known names when there is no such effect.
const EffectType& find_effect(const std::string& name);

}  // namespace wheel_twin::effects
