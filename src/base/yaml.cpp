#include "base/yaml.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>

#include "base/error.h"

namespace wheel_twin::yaml {
namespace {

std::string where(const std::string& file, const YAML::Mark& mark) {
  return mark.is_null() ? file : fmt::format("{}:{}", file, mark.line + 1);
}

[[noreturn]] void refuse(const std::string& file, const YAML::Mark& mark, const std::string& key,
                         const std::string& message) {
  throw Error(fmt::format("{}: {}: {}", where(file, mark), key, message));
}

std::string scalar(const YAML::Node& node, const std::string& file, const std::string& key) {
  if (!node.IsScalar())
    refuse(file, node.Mark(), key, node.IsNull() ? "has no value" : "a single value is expected");
  return node.Scalar();
}

bool is_quoted(const YAML::Node& node) {
  return node.Tag() == "!";
}

bool has_leading_zero(std::string_view text) {
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) text.remove_prefix(1);
  return text.size() > 1 && text[0] == '0' && text[1] >= '0' && text[1] <= '9';
}

double to_number(const YAML::Node& node, const std::string& file, const std::string& key, Range range) {
  const std::string text = scalar(node, file, key);
  if (is_quoted(node))
    refuse(file, node.Mark(), key, fmt::format("a number is expected, '{}' is quoted text", text));
  if (has_leading_zero(text))
    refuse(file, node.Mark(), key,
           fmt::format("'{}' is octal in YAML and decimal to a person: drop the zero", text));
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (begin != end && *begin == '+') ++begin;
  double value = 0.0;
  const auto [stop, code] = std::from_chars(begin, end, value);
  if (code != std::errc() || stop != end)
    refuse(file, node.Mark(), key, fmt::format("a number is expected, not '{}'", text));
  if (!std::isfinite(value) || value < range.minimum || value > range.maximum) {
    std::string bounds;
    if (range.minimum == std::numeric_limits<double>::min())
      bounds = "above 0";
    else if (std::isfinite(range.minimum))
      bounds = fmt::format("at least {}", range.minimum);
    if (std::isfinite(range.maximum) && range.maximum < std::numeric_limits<double>::max())
      bounds += fmt::format("{}at most {}", bounds.empty() ? "" : " and ", range.maximum);
    refuse(file, node.Mark(), key,
           fmt::format("{} is out of range: {}", text, bounds.empty() ? "finite" : bounds));
  }
  return value;
}

std::int64_t to_integer(const YAML::Node& node, const std::string& file, const std::string& key,
                        std::int64_t minimum, std::int64_t maximum) {
  const std::string text = scalar(node, file, key);
  if (is_quoted(node))
    refuse(file, node.Mark(), key, fmt::format("an integer is expected, '{}' is quoted", text));
  if (has_leading_zero(text))
    refuse(file, node.Mark(), key,
           fmt::format("'{}' is octal in YAML and decimal to a person: drop the zero", text));
  std::int64_t value = 0;
  const auto [stop, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || stop != text.data() + text.size())
    refuse(file, node.Mark(), key, fmt::format("an integer is expected, not '{}'", text));
  if (value < minimum || value > maximum)
    refuse(file, node.Mark(), key, fmt::format("{} is out of range: {} to {}", value, minimum, maximum));
  return value;
}

std::string to_text(const YAML::Node& node, const std::string& file, const std::string& key) {
  std::string text = scalar(node, file, key);
  if (text.empty()) refuse(file, node.Mark(), key, "is empty");
  return text;
}

}  // namespace

struct Map::Impl {
  std::string file;
  std::string path;  // of keys, for messages
  YAML::Node node;
  std::vector<std::pair<std::string, YAML::Node>> entries;
  std::set<std::string> read;

  Impl(std::string file_name, std::string key_path, const YAML::Node& source)
      : file(std::move(file_name)), path(std::move(key_path)), node(source) {
    if (!node.IsMap()) refuse(file, node.Mark(), path.empty() ? "top level" : path, "a mapping is expected");
    for (const auto& entry : node) {
      if (!entry.first.IsScalar()) refuse(file, entry.first.Mark(), path, "a key must be a single value");
      const std::string key = entry.first.Scalar();
      for (const auto& earlier : entries)
        if (earlier.first == key) refuse(file, entry.first.Mark(), name(key), "stands here a second time");
      entries.emplace_back(key, entry.second);
    }
  }

  std::string name(const std::string& key) const { return path.empty() ? key : path + "." + key; }

  const YAML::Node* find(const std::string& key) {
    for (const auto& entry : entries)
      if (entry.first == key) {
        read.insert(key);
        return &entry.second;
      }
    return nullptr;
  }

  const YAML::Node& get(const std::string& key) {
    const YAML::Node* found = find(key);
    if (found == nullptr) refuse(file, node.Mark(), name(key), "is missing");
    return *found;
  }
};

struct List::Impl {
  std::string file;
  std::string path;
  YAML::Node node;

  std::string name(std::size_t index) const { return fmt::format("{}[{}]", path, index); }
};

bool Map::has(const std::string& key) const {
  return std::any_of(impl_->entries.begin(), impl_->entries.end(),
                     [&](const auto& e) { return e.first == key; });
}

bool Map::is_null(const std::string& key) const {
  const YAML::Node* node = has(key) ? impl_->find(key) : nullptr;
  return node != nullptr && node->IsNull();
}

bool Map::is_map(const std::string& key) const {
  return has(key) && impl_->find(key)->IsMap();
}
bool Map::is_list(const std::string& key) const {
  return has(key) && impl_->find(key)->IsSequence();
}

std::vector<std::string> Map::keys() const {
  std::vector<std::string> names;
  for (const auto& entry : impl_->entries) names.push_back(entry.first);
  return names;
}

double Map::number(const std::string& key, Range range) const {
  return to_number(impl_->get(key), impl_->file, impl_->name(key), range);
}

double Map::number_or(const std::string& key, double fallback, Range range) const {
  return has(key) ? number(key, range) : fallback;
}

std::optional<double> Map::optional_number(const std::string& key, Range range) const {
  if (!has(key) || is_null(key)) return std::nullopt;
  return number(key, range);
}

std::int64_t Map::integer(const std::string& key, std::int64_t minimum, std::int64_t maximum) const {
  return to_integer(impl_->get(key), impl_->file, impl_->name(key), minimum, maximum);
}

std::int64_t Map::integer_or(const std::string& key, std::int64_t fallback, std::int64_t minimum,
                             std::int64_t maximum) const {
  return has(key) ? integer(key, minimum, maximum) : fallback;
}

bool Map::boolean(const std::string& key) const {
  const YAML::Node& node = impl_->get(key);
  const std::string text = scalar(node, impl_->file, impl_->name(key));
  if (text == "true" && !is_quoted(node)) return true;
  if (text == "false" && !is_quoted(node)) return false;
  refuse(impl_->file, node.Mark(), impl_->name(key), fmt::format("write true or false, not '{}'", text));
}

bool Map::boolean_or(const std::string& key, bool fallback) const {
  return has(key) ? boolean(key) : fallback;
}

std::string Map::text(const std::string& key) const {
  return to_text(impl_->get(key), impl_->file, impl_->name(key));
}

std::string Map::text_or(const std::string& key, const std::string& fallback) const {
  return has(key) ? text(key) : fallback;
}

std::vector<double> Map::numbers(const std::string& key, Range range) const {
  const List values = list(key);
  std::vector<double> result(values.size());
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = values.number(i, range);
  return result;
}

Map Map::map(const std::string& key) const {
  return Map(std::make_shared<Impl>(impl_->file, impl_->name(key), impl_->get(key)));
}

std::optional<Map> Map::optional_map(const std::string& key) const {
  if (!has(key) || is_null(key)) return std::nullopt;
  return map(key);
}

List Map::list(const std::string& key) const {
  const YAML::Node& node = impl_->get(key);
  if (!node.IsSequence()) refuse(impl_->file, node.Mark(), impl_->name(key), "a list is expected");
  auto impl = std::make_shared<List::Impl>();
  impl->file = impl_->file;
  impl->path = impl_->name(key);
  impl->node = node;
  return List(std::move(impl));
}

void Map::skip(const std::string& key) const {
  impl_->find(key);
}

void Map::finish() const {
  for (const auto& entry : impl_->entries)
    if (impl_->read.count(entry.first) == 0)
      refuse(impl_->file, entry.second.Mark(), impl_->name(entry.first), "is not a known key");
}

void Map::fail(const std::string& key, const std::string& message) const {
  const YAML::Node* node = impl_->find(key);
  refuse(impl_->file, node != nullptr ? node->Mark() : impl_->node.Mark(), impl_->name(key), message);
}

const std::string& Map::file() const {
  return impl_->file;
}

std::size_t List::size() const {
  return impl_->node.size();
}

Map List::map(std::size_t index) const {
  return Map(std::make_shared<Map::Impl>(impl_->file, impl_->name(index), impl_->node[index]));
}

double List::number(std::size_t index, Range range) const {
  return to_number(impl_->node[index], impl_->file, impl_->name(index), range);
}

std::string List::text(std::size_t index) const {
  return to_text(impl_->node[index], impl_->file, impl_->name(index));
}

Map parse_text(const std::string& text, const std::string& name) {
  YAML::Node node;
  try {
    node = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw Error(fmt::format("{}: not YAML: {}", where(name, error.mark), error.msg));
  }
  if (!node.IsMap()) throw Error(fmt::format("{}: the top level must be a mapping of keys to values", name));
  return Map(std::make_shared<Map::Impl>(name, "", node));
}

Map parse_file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Error(fmt::format("{}: cannot be opened", path));
  std::ostringstream text;
  text << stream.rdbuf();
  if (stream.bad() || text.fail()) throw Error(fmt::format("{}: cannot be read or is empty", path));
  return parse_text(text.str(), path);
}

}  // namespace wheel_twin::yaml
