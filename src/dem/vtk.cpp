#include "dem/vtk.h"

#include <fmt/format.h>

#include <cstdint>
#include <fstream>
#include <numeric>

#include "base/atomic_file.h"
#include "base/error.h"

namespace wheel_twin::dem {
namespace {

// Collects the blocks of the appended section; each is a UInt64 length and the bytes.
class Appended {
 public:
  template <typename T>
  std::uint64_t add(const std::vector<T>& values) {
    const std::uint64_t offset = bytes_.size();
    const std::uint64_t size = values.size() * sizeof(T);
    bytes_.append(reinterpret_cast<const char*>(&size), sizeof size);
    if (size > 0) bytes_.append(reinterpret_cast<const char*>(values.data()), size);
    return offset;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

std::string data_array(const char* type, const std::string& name, int components, std::uint64_t offset) {
  return fmt::format(
      "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
      type, name, components, offset);
}

}  // namespace

void write_vtp(const std::string& path, const VtkPolyData& data) {
  const std::size_t points = data.points.size() / 3;
  for (const VtkField& field : data.fields)
    if (field.values.size() != points * field.components)
      throw Error(fmt::format("{}: field '{}' has {} values for {} points", path, field.name,
                              field.values.size(), points));

  Appended appended;
  std::string point_data;
  for (const VtkField& field : data.fields)
    point_data += data_array("Float32", field.name, field.components, appended.add(field.values));
  const std::string coordinates = data_array("Float32", "Points", 3, appended.add(data.points));

  const bool surface = !data.triangles.empty();
  const std::size_t cells = surface ? data.triangles.size() / 3 : points;
  std::vector<std::int32_t> connectivity = data.triangles;
  if (!surface) {
    connectivity.resize(points);
    std::iota(connectivity.begin(), connectivity.end(), 0);
  }
  std::vector<std::int32_t> ends(cells);
  for (std::size_t i = 0; i < cells; ++i) ends[i] = static_cast<std::int32_t>((i + 1) * (surface ? 3 : 1));
  const std::uint64_t connectivity_offset = appended.add(connectivity);
  const std::uint64_t ends_offset = appended.add(ends);
  const char* kind = surface ? "Polys" : "Verts";

  AtomicFile file(path);
  {
    std::ofstream out(file.path(), std::ios::binary);
    out << "<?xml version=\"1.0\"?>\n"
           "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
           "header_type=\"UInt64\">\n<PolyData>\n"
        << fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfPolys=\"{}\">\n", points,
                       surface ? 0 : cells, surface ? cells : 0)
        << "<PointData>\n"
        << point_data << "</PointData>\n<Points>\n"
        << coordinates << "</Points>\n"
        << fmt::format("<{}>\n", kind) << data_array("Int32", "connectivity", 1, connectivity_offset)
        << data_array("Int32", "offsets", 1, ends_offset) << fmt::format("</{}>\n", kind)
        << "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
    out.write(appended.bytes().data(), static_cast<std::streamsize>(appended.bytes().size()));
    out << "\n</AppendedData>\n</VTKFile>\n";
    out.close();
    if (!out) throw Error(fmt::format("{}: cannot be written", path));
  }
  file.commit();
}

}  // namespace wheel_twin::dem
