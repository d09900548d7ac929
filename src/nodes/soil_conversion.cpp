#include "nodes/soil_conversion.h"

#include <cmath>
#include <cstring>
#include <initializer_list>
#include <vector>

#include "cosim/grains.h"

namespace wheel_twin::nodes {
namespace {

sensor_msgs::PointCloud2 float_cloud(std::initializer_list<const char*> fields, std::size_t width,
                                     std::size_t height, const std_msgs::Header& header) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header = header;
  cloud.width = static_cast<std::uint32_t>(width);
  cloud.height = static_cast<std::uint32_t>(height);
  for (const char* name : fields) {
    sensor_msgs::PointField field;
    field.name = name;
    field.offset = static_cast<std::uint32_t>(4 * cloud.fields.size());
    field.datatype = sensor_msgs::PointField::FLOAT32;
    field.count = 1;
    cloud.fields.push_back(field);
  }
  cloud.is_bigendian = 0;
  cloud.point_step = static_cast<std::uint32_t>(4 * fields.size());
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.data.resize(static_cast<std::size_t>(cloud.row_step) * height);
  return cloud;
}

void put(sensor_msgs::PointCloud2& cloud, std::size_t point, std::initializer_list<double> values) {
  std::uint8_t* place = &cloud.data[point * cloud.point_step];
  for (const double value : values) {
    const auto number = static_cast<float>(value);
    std::memcpy(place, &number, sizeof number);
    place += sizeof number;
  }
}

}  // namespace

sensor_msgs::PointCloud2 soil_cloud(const dem::System& system, const std::vector<dem::SphereState>& spheres,
                                    const std_msgs::Header& header) {
  const std::vector<cosim::SphereMotion> motions = cosim::sphere_motions(system);
  sensor_msgs::PointCloud2 cloud =
      float_cloud({"x", "y", "z", "radius", "speed", "force"}, spheres.size(), 1, header);
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Eigen::Vector3d& x = spheres[i].center;
    put(cloud, i, {x.x(), x.y(), x.z(), spheres[i].radius, motions[i].speed, motions[i].force});
  }
  cloud.is_dense = 1;
  return cloud;
}

sensor_msgs::PointCloud2 height_cloud(const dem::HeightMap& map, const std_msgs::Header& header) {
  sensor_msgs::PointCloud2 cloud = float_cloud({"x", "y", "z"}, map.columns, map.rows, header);
  for (int row = 0; row < map.rows; ++row)
    for (int column = 0; column < map.columns; ++column)
      put(cloud, static_cast<std::size_t>(row) * map.columns + column,
          {map.x + column * map.spacing, map.y + row * map.spacing, map.at(column, row)});
  cloud.is_dense = 0;
  return cloud;
}

visualization_msgs::Marker rut_profile(const dem::HeightMap& map, double half_width,
                                       const std_msgs::Header& header) {
  visualization_msgs::Marker line;
  line.header = header;
  line.ns = "rut";
  line.type = visualization_msgs::Marker::LINE_STRIP;
  line.action = visualization_msgs::Marker::ADD;
  line.pose.orientation.w = 1.0;
  line.scale.x = 0.002;
  line.color.r = 0.84F;
  line.color.g = 0.37F;
  line.color.a = 1.0F;
  for (int column = 0; column < map.columns; ++column) {
    double sum = 0.0;
    int count = 0;
    for (int row = 0; row < map.rows; ++row) {
      const double height = map.at(column, row);
      if (std::abs(map.y + row * map.spacing) > half_width || !std::isfinite(height)) continue;
      sum += height;
      ++count;
    }
    if (count == 0) continue;
    geometry_msgs::Point point;
    point.x = map.x + column * map.spacing;
    point.z = sum / count;
    line.points.push_back(point);
  }
  return line;
}

}  // namespace wheel_twin::nodes
