// What rig, wheel and soil of a co-simulation say to one another, as messages and back. Every number passes
// bit by bit. Frame `rig`, SI units.
#pragma once

#include <wheel_twin/HubLoad.h>
#include <wheel_twin/HubMotion.h>
#include <wheel_twin/SegmentLoads.h>
#include <wheel_twin/SegmentMotion.h>

#include <vector>

#include "rig/contact.h"
#include "wheel/flexible_wheel.h"

namespace wheel_twin::nodes {

void put(const rig::HubMotion& motion, HubMotion& message);
rig::HubMotion from_message(const HubMotion& message);

void put(const rig::HubLoad& load, HubLoad& message);
rig::HubLoad from_message(const HubLoad& message);

void put(const std::vector<wheel::SegmentState>& segments, SegmentMotion& message);
/// Throws Error naming the step when poses and twists differ in number.
std::vector<wheel::SegmentState> from_message(const SegmentMotion& message);

void put(const std::vector<wheel::Wrench>& loads, SegmentLoads& message);
std::vector<wheel::Wrench> from_message(const SegmentLoads& message);

}  // namespace wheel_twin::nodes
