#include "wheel/ground.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "base/error.h"

namespace wheel_twin::wheel {
namespace {

using Eigen::Vector3d;

Vector3d read_vector(const yaml::Map& map, const std::string& key, yaml::Range range = {-1.0e3, 1.0e3}) {
  const std::vector<double> values = map.numbers(key, range);
  if (values.size() != 3)
    map.fail(key, fmt::format("three numbers x, y, z are expected, not {}", values.size()));
  return {values[0], values[1], values[2]};
}

/// The number of a face's corner: 7, 7/1 and 7/1/2 are vertex 7; -1 is the last one so far.
int corner(const std::string& word, std::size_t vertices) {
  const std::string number = word.substr(0, word.find('/'));
  std::size_t end = 0;
  int index = 0;
  try {
    index = std::stoi(number, &end);
  } catch (const std::exception&) {
    return -1;
  }
  if (end != number.size() || index == 0) return -1;
  const int position = index > 0 ? index - 1 : static_cast<int>(vertices) + index;
  return position < static_cast<int>(vertices) ? position : -1;
}

}  // namespace

GroundRock read_obj(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw Error(fmt::format("{}: cannot be read", path));
  GroundRock rock;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      Vector3d v;
      if (!(words >> v.x() >> v.y() >> v.z()) || !v.allFinite())
        throw Error(fmt::format("{}:{}: a vertex is three numbers", path, number));
      rock.vertices.push_back(v);
    } else if (kind == "f") {
      std::vector<int> corners;
      for (std::string word; words >> word;) {
        corners.push_back(corner(word, rock.vertices.size()));
        if (corners.back() < 0)
          throw Error(
              fmt::format("{}:{}: '{}' is none of {} vertices", path, number, word, rock.vertices.size()));
      }
      if (corners.size() < 3)
        throw Error(
            fmt::format("{}:{}: a face has three corners at least, not {}", path, number, corners.size()));
      for (std::size_t k = 2; k < corners.size(); ++k)
        rock.triangles.push_back({corners[0], corners[k - 1], corners[k]});
    }
  }
  if (rock.triangles.empty()) throw Error(fmt::format("{}: there are no faces in it", path));
  return rock;
}

Ground read_ground(const yaml::Map& map) {
  Ground ground;
  ground.name = map.text_or("name", ground.name);
  ground.floor = map.optional_number("floor", {-10.0, 10.0});
  if (map.has("boxes")) {
    const yaml::List boxes = map.list("boxes");
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const yaml::Map entry = boxes.map(i);
      ground.boxes.push_back({read_vector(entry, "centre"), read_vector(entry, "size", {1.0e-4, 1.0e3}),
                              entry.number_or("pitch", 0.0, {-1.5, 1.5})});
      entry.finish();
    }
  }
  if (map.has("spheres")) {
    const yaml::List spheres = map.list("spheres");
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      const yaml::Map entry = spheres.map(i);
      ground.spheres.push_back({read_vector(entry, "centre"), entry.number("radius", {1.0e-4, 1.0e2})});
      entry.finish();
    }
  }
  if (map.has("rocks")) {
    const yaml::List rocks = map.list("rocks");
    const std::size_t slash = map.file().rfind('/');
    const std::string folder = slash == std::string::npos ? "" : map.file().substr(0, slash + 1);
    for (std::size_t i = 0; i < rocks.size(); ++i) {
      const yaml::Map entry = rocks.map(i);
      const std::string file = entry.text("file");
      GroundRock rock = read_obj(file.front() == '/' ? file : folder + file);
      if (entry.has("at")) {
        const Vector3d at = read_vector(entry, "at");
        for (Vector3d& v : rock.vertices) v += at;
      }
      entry.finish();
      ground.rocks.push_back(std::move(rock));
    }
  }
  ground.contact.stiffness = map.number_or("stiffness", ground.contact.stiffness, {1.0e3, 1.0e8});
  ground.contact.damping = map.number_or("damping", 0.0, {0.0, 1.0e4});
  ground.contact.friction = map.number_or("friction", 0.0, {0.0, 10.0});
  map.finish();
  if (!ground.floor && ground.boxes.empty() && ground.spheres.empty() && ground.rocks.empty())
    throw Error(fmt::format("{}: no ground: a floor, boxes, spheres or rocks are needed", map.file()));
  return ground;
}

Ground read_ground_file(const std::string& path) {
  return read_ground(yaml::parse_file(path));
}

}  // namespace wheel_twin::wheel
