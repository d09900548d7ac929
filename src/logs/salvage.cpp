#include "logs/salvage.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "base/atomic_file.h"
#include "base/error.h"
#include "logs/bag_file.h"

namespace wheel_twin::logs {

std::string salvaged_name(const std::string& path) {
  std::string stem = path;
  for (const std::string& ending : {std::string(".active"), std::string(".bag")})
    if (stem.size() > ending.size() && stem.compare(stem.size() - ending.size(), ending.size(), ending) == 0)
      stem.resize(stem.size() - ending.size());
  return stem + ".salvaged.bag";
}

Salvage salvage_bag(const std::string& path) {
  Salvage salvage;
  salvage.output = salvaged_name(path);
  if (std::filesystem::exists(salvage.output))
    throw Error(fmt::format("{}: exists already, and {} would be salvaged to it", salvage.output, path));
  AtomicFile file(salvage.output);
  {
    BagFile bag(file.path(), salvage.output, Compression::lz4);
    std::map<std::uint32_t, std::uint32_t> connections;
    std::uint64_t last_time = 1;
    salvage.summary = scan_bag(path, [&](const BagMessage& message) {
      const BagConnection& from = *message.connection;
      auto to = connections.find(from.id);
      if (to == connections.end())
        to = connections.emplace(from.id, bag.add_connection(from.topic, from.header)).first;
      if (message.time == 0) ++salvage.time_zero;
      last_time = message.time == 0 ? last_time : message.time;
      bag.write(to->second, last_time, message.data, message.size);
      ++salvage.written[from.topic];
    });
    bag.close();
  }
  if (salvage.summary.intact() && salvage.time_zero == 0) {
    salvage.output.clear();
    return salvage;
  }
  if (salvage.summary.messages == 0)
    throw Error(fmt::format("{}: no message in it can be read: nothing is salvaged", path));
  file.commit();
  return salvage;
}

}  // namespace wheel_twin::logs
