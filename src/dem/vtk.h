// Export for ParaView: XML PolyData (.vtp), appended raw binary, little endian, coordinates in m, frame of
// the bed (x along travel, y to the left, z up). Spheres as points with fields: draw them with the Point
// Gaussian or Glyph representation scaled by "radius".
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace wheel_twin::dem {

struct VtkField {
  std::string name;
  int components = 1;         ///< 1 or 3
  std::vector<float> values;  ///< components a point
};

struct VtkPolyData {
  std::vector<float> points;            ///< x, y, z of every point
  std::vector<std::int32_t> triangles;  ///< three point numbers each; without any, every point is a vertex
  std::vector<VtkField> fields;         ///< a value for every point
};

/// Writes atomically. Throws Error naming the file; a field whose length does not fit the points is an Error
/// too.
void write_vtp(const std::string& path, const VtkPolyData& data);

}  // namespace wheel_twin::dem
