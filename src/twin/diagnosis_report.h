// What a diagnosis leaves in its folder: diagnosis.json, revised_twin.yaml, errors.csv and one self-contained
// page.
#pragma once

#include <string>

#include "twin/diagnosis.h"

namespace wheel_twin::twin {

std::string diagnosis_json(const Diagnosis& diagnosis);
std::string diagnosis_page(const Diagnosis& diagnosis);

/// Makes `directory` when missing; each file appears whole or not at all.
void write_diagnosis(const Diagnosis& diagnosis, const std::string& directory);

}  // namespace wheel_twin::twin
