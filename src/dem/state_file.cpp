#include "dem/state_file.h"

#include <fmt/format.h>

#include <utility>

#include "base/error.h"

namespace wheel_twin::dem {
namespace {

template <typename Vector>
void put_vectors(Archive& archive, const std::string& name, const std::vector<Vector>& values) {
  constexpr int columns = Vector::RowsAtCompileTime;
  std::vector<double> flat;
  flat.reserve(values.size() * columns);
  for (const Vector& v : values) flat.insert(flat.end(), v.data(), v.data() + columns);
  archive.set(name, std::move(flat), columns);
}

template <typename Vector>
std::vector<Vector> get_vectors(const Archive& archive, const std::string& name) {
  constexpr int columns = Vector::RowsAtCompileTime;
  const std::vector<double>& flat = archive.get<double>(name);
  std::vector<Vector> values(flat.size() / columns);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = Eigen::Map<const Vector>(&flat[columns * i]);
  return values;
}

void put_contacts(Archive& archive, const std::string& name, const std::vector<ContactHistory>& contacts) {
  std::vector<std::uint32_t> keys;
  std::vector<float> springs;
  keys.reserve(3 * contacts.size());
  springs.reserve(7 * contacts.size());
  for (const ContactHistory& c : contacts) {
    keys.insert(keys.end(), {c.a, c.b, c.facet});
    springs.insert(springs.end(),
                   {c.overlap, c.shear[0], c.shear[1], c.shear[2], c.rolling[0], c.rolling[1], c.rolling[2]});
  }
  archive.set(name + "_keys", std::move(keys), 3);
  archive.set(name + "_springs", std::move(springs), 7);
}

std::vector<ContactHistory> get_contacts(const Archive& archive, const std::string& name) {
  const auto& keys = archive.get<std::uint32_t>(name + "_keys");
  const auto& springs = archive.get<float>(name + "_springs");
  if (keys.size() / 3 != springs.size() / 7)
    throw Error(fmt::format("{}: keys and springs differ in number", name));
  std::vector<ContactHistory> contacts(keys.size() / 3);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    ContactHistory& c = contacts[i];
    c.a = keys[3 * i];
    c.b = keys[3 * i + 1];
    c.facet = keys[3 * i + 2];
    const float* s = &springs[7 * i];
    c.overlap = s[0];
    c.shear = {s[1], s[2], s[3]};
    c.rolling = {s[4], s[5], s[6]};
  }
  return contacts;
}

enum class ShapeKind : std::uint32_t { half_space, revolved, mesh };

void put_walls(Archive& archive, const std::vector<Wall>& walls) {
  std::vector<double> motion;          // pose and motion, 13 numbers a wall
  std::vector<double> geometry;        // numbers of all shapes, one after the other
  std::vector<std::int64_t> layout;    // kind, material, surface, numbers, triangle corners
  std::vector<std::uint32_t> corners;  // triangle corners of all meshes
  std::string names;
  for (const Wall& wall : walls) {
    const Eigen::Vector3d& p = wall.pose.position;
    const Eigen::Quaterniond& q = wall.pose.orientation;
    const Eigen::Vector3d& v = wall.motion.velocity;
    const Eigen::Vector3d& w = wall.motion.angular_velocity;
    motion.insert(motion.end(), {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z(), v.x(), v.y(), v.z(), w.x(),
                                 w.y(), w.z()});
    const std::size_t numbers_before = geometry.size();
    const std::size_t corners_before = corners.size();
    if (const auto* plane = std::get_if<HalfSpace>(&wall.shape)) {
      geometry.insert(geometry.end(), plane->normal.data(), plane->normal.data() + 3);
    } else if (const auto* revolved = std::get_if<Revolved>(&wall.shape)) {
      for (const Eigen::Vector2d& point : revolved->profile)
        geometry.insert(geometry.end(), {point.x(), point.y()});
    } else {
      const Mesh& mesh = std::get<Mesh>(wall.shape);
      for (const Eigen::Vector3d& x : mesh.vertices) geometry.insert(geometry.end(), x.data(), x.data() + 3);
      for (const auto& t : mesh.triangles) corners.insert(corners.end(), t.begin(), t.end());
    }
    layout.insert(layout.end(), {static_cast<std::int64_t>(wall.shape.index()), wall.material, wall.surface,
                                 static_cast<std::int64_t>(geometry.size() - numbers_before),
                                 static_cast<std::int64_t>(corners.size() - corners_before)});
    names += wall.name + '\n';
  }
  archive.set("wall_motion", std::move(motion), 13);
  archive.set("wall_geometry", std::move(geometry));
  archive.set("wall_layout", std::move(layout), 5);
  archive.set("wall_corners", std::move(corners));
  archive.set_text("wall_names", names);
}

std::vector<Wall> get_walls(const Archive& archive) {
  const auto& motion = archive.get<double>("wall_motion");
  const auto& geometry = archive.get<double>("wall_geometry");
  const auto& layout = archive.get<std::int64_t>("wall_layout");
  const auto& corners = archive.get<std::uint32_t>("wall_corners");
  std::string names = archive.text("wall_names");
  std::vector<Wall> walls(layout.size() / 5);
  std::size_t number = 0;
  std::size_t corner = 0;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    Wall& wall = walls[i];
    const std::size_t line = names.find('\n');
    wall.name = names.substr(0, line);
    names.erase(0, line + 1);
    const double* m = &motion.at(13 * i);
    wall.pose.position = {m[0], m[1], m[2]};
    wall.pose.orientation = Eigen::Quaterniond(m[3], m[4], m[5], m[6]);
    wall.motion.velocity = {m[7], m[8], m[9]};
    wall.motion.angular_velocity = {m[10], m[11], m[12]};
    const std::int64_t* l = &layout[5 * i];
    wall.material = static_cast<std::uint32_t>(l[1]);
    wall.surface = static_cast<std::int32_t>(l[2]);
    const std::size_t numbers = l[3];
    const std::size_t triangle_corners = l[4];
    if (number + numbers > geometry.size() || corner + triangle_corners > corners.size())
      throw Error(fmt::format("wall '{}': its geometry is incomplete", wall.name));
    const double* g = geometry.data() + number;
    switch (static_cast<ShapeKind>(l[0])) {
      case ShapeKind::half_space:
        wall.shape = HalfSpace{Eigen::Map<const Eigen::Vector3d>(g)};
        break;
      case ShapeKind::revolved: {
        Revolved revolved;
        for (std::size_t k = 0; k + 1 < numbers; k += 2) revolved.profile.emplace_back(g[k], g[k + 1]);
        wall.shape = std::move(revolved);
        break;
      }
      case ShapeKind::mesh: {
        Mesh mesh;
        for (std::size_t k = 0; k + 2 < numbers; k += 3) mesh.vertices.emplace_back(g[k], g[k + 1], g[k + 2]);
        for (std::size_t k = 0; k + 2 < triangle_corners; k += 3)
          mesh.triangles.push_back({corners[corner + k], corners[corner + k + 1], corners[corner + k + 2]});
        wall.shape = std::move(mesh);
        break;
      }
      default:
        throw Error(fmt::format("wall '{}': shape of an unknown kind", wall.name));
    }
    number += numbers;
    corner += triangle_corners;
  }
  return walls;
}

}  // namespace

void store(const State& state, Archive& archive) {
  archive.set("step", std::vector<std::int64_t>{state.step});
  archive.set("shape", state.shape);
  archive.set("material", state.material);
  archive.set("size", state.size);
  archive.set("stiffness", state.stiffness);
  put_vectors(archive, "position", state.position);
  put_vectors(archive, "velocity", state.velocity);
  put_vectors(archive, "angular_momentum", state.angular_momentum);
  put_vectors(archive, "orientation", state.orientation);
  put_vectors(archive, "load", state.load);
  put_contacts(archive, "contact", state.contacts);
  put_contacts(archive, "wall_contact", state.wall_contacts);
  put_walls(archive, state.walls);
  archive.set("wall_removed",
              std::vector<std::uint32_t>(state.wall_removed.begin(), state.wall_removed.end()));
  if (!state.asleep.empty()) {
    archive.set("asleep", std::vector<std::uint32_t>(state.asleep.begin(), state.asleep.end()));
    archive.set("quiet", state.quiet);
    put_vectors(archive, "looked_at", state.looked_at);
    if (!state.hold.empty()) archive.set("hold", state.hold);
  }
}

State load_state(const Archive& archive) {
  State state;
  const auto& step = archive.get<std::int64_t>("step");
  state.step = step.empty() ? 0 : step[0];
  state.shape = archive.get<std::uint32_t>("shape");
  state.material = archive.get<std::uint32_t>("material");
  state.size = archive.get<float>("size");
  state.stiffness = archive.get<float>("stiffness");
  state.position = get_vectors<Eigen::Vector3d>(archive, "position");
  state.velocity = get_vectors<Eigen::Vector3d>(archive, "velocity");
  state.angular_momentum = get_vectors<Eigen::Vector3d>(archive, "angular_momentum");
  state.orientation = get_vectors<Eigen::Vector4d>(archive, "orientation");
  state.load = get_vectors<Eigen::Matrix<double, 7, 1>>(archive, "load");
  state.contacts = get_contacts(archive, "contact");
  state.wall_contacts = get_contacts(archive, "wall_contact");
  state.walls = get_walls(archive);
  const auto& removed = archive.get<std::uint32_t>("wall_removed");
  state.wall_removed.assign(removed.begin(), removed.end());
  if (archive.has("asleep")) {
    const auto& asleep = archive.get<std::uint32_t>("asleep");
    state.asleep.assign(asleep.begin(), asleep.end());
    state.quiet = archive.get<std::uint32_t>("quiet");
    state.looked_at = get_vectors<Eigen::Vector3d>(archive, "looked_at");
    if (archive.has("hold")) state.hold = archive.get<double>("hold");
  }
  return state;
}

std::string system_fingerprint(const System& system) {
  const WorldSettings& s = system.settings();
  std::string text =
      fmt::format("domain {} {} {} {} {} {} {} {} step {}\n", s.low.x(), s.low.y(), s.low.z(), s.high.x(),
                  s.high.y(), s.high.z(), s.periodic_x, s.periodic_y, system.time_step());
  const MaterialTable& materials = system.materials();
  for (std::uint32_t i = 0; i < materials.size(); ++i) {
    const Material& m = materials[i];
    text += fmt::format("material {} {} {}\n", m.density, m.shear_modulus, m.poisson_ratio);
  }
  for (const ClumpTemplate& shape : system.templates())
    for (const ClumpSphere& sphere : shape.spheres)
      text += fmt::format("sphere {} {} {} {}\n", sphere.center.x(), sphere.center.y(), sphere.center.z(),
                          sphere.radius);
  return sha256(text);
}

void write_checkpoint(const std::string& path, const System& system) {
  Archive archive;
  store(system.state(), archive);
  archive.set_text("system", system_fingerprint(system));
  write_archive(path, "checkpoint", archive);
}

void restore_checkpoint(const std::string& path, System& system) {
  const Archive archive = read_archive(path, "checkpoint");
  if (archive.text("system") != system_fingerprint(system))
    throw Error(
        fmt::format("{}: belongs to another system: clumps, materials, domain or time step differ", path));
  system.restore(load_state(archive));
}

Checkpoints::Checkpoints(std::string path, double interval)
    : path_(std::move(path)), interval_(interval), written_(Clock::now()) {}

void Checkpoints::update(const System& system) {
  const auto now = Clock::now();
  if (now - written_ < interval_) return;
  write_checkpoint(path_, system);
  written_ = Clock::now();
}

}  // namespace wheel_twin::dem
