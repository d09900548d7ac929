#include "logs/message_definition.h"

#include <fmt/format.h>

#include <cstring>
#include <map>
#include <optional>
#include <sstream>

#include "base/error.h"

namespace wheel_twin::logs {
namespace {

enum class Scalar { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

const std::map<std::string, Scalar>& scalars() {
  static const std::map<std::string, Scalar> table = {
      {"bool", Scalar::uint8},     {"byte", Scalar::int8},     {"char", Scalar::uint8},
      {"int8", Scalar::int8},      {"uint8", Scalar::uint8},   {"int16", Scalar::int16},
      {"uint16", Scalar::uint16},  {"int32", Scalar::int32},   {"uint32", Scalar::uint32},
      {"int64", Scalar::int64},    {"uint64", Scalar::uint64}, {"float32", Scalar::float32},
      {"float64", Scalar::float64}};
  return table;
}

std::size_t size_of(Scalar scalar) {
  switch (scalar) {
    case Scalar::int8:
    case Scalar::uint8:
      return 1;
    case Scalar::int16:
    case Scalar::uint16:
      return 2;
    case Scalar::int32:
    case Scalar::uint32:
    case Scalar::float32:
      return 4;
    default:
      return 8;
  }
}

template <typename T>
double load(const std::uint8_t* data) {
  T value;
  std::memcpy(&value, data, sizeof value);
  return static_cast<double>(value);
}

double decode(Scalar scalar, const std::uint8_t* data) {
  switch (scalar) {
    case Scalar::int8:
      return load<std::int8_t>(data);
    case Scalar::uint8:
      return load<std::uint8_t>(data);
    case Scalar::int16:
      return load<std::int16_t>(data);
    case Scalar::uint16:
      return load<std::uint16_t>(data);
    case Scalar::int32:
      return load<std::int32_t>(data);
    case Scalar::uint32:
      return load<std::uint32_t>(data);
    case Scalar::int64:
      return load<std::int64_t>(data);
    case Scalar::uint64:
      return load<std::uint64_t>(data);
    case Scalar::float32:
      return load<float>(data);
    case Scalar::float64:
      return load<double>(data);
  }
  return 0.0;
}

struct Struct;

struct Field {
  std::string name;
  std::optional<Scalar> scalar;  // none: a string or a structure
  bool is_string = false;
  std::shared_ptr<Struct> structure;
  bool is_array = false;
  std::optional<std::size_t> count;  // of a fixed array
  int slot = -1;                     // where the value goes
};

struct Struct {
  std::vector<Field> fields;
};

struct Cursor {
  const std::uint8_t* data;
  std::size_t left;
  const std::string& type;

  const std::uint8_t* take(std::size_t bytes) {
    if (bytes > left) throw Error(fmt::format("{}: a message is shorter than its definition says", type));
    const std::uint8_t* taken = data;
    data += bytes;
    left -= bytes;
    return taken;
  }
  std::size_t length() { return static_cast<std::size_t>(load<std::uint32_t>(take(4))); }
};

void walk(const Struct& structure, Cursor& cursor, std::vector<double>& values);

void walk_one(const Field& field, Cursor& cursor, std::vector<double>& values) {
  if (field.scalar) {
    const std::uint8_t* bytes = cursor.take(size_of(*field.scalar));
    if (field.slot >= 0) values[static_cast<std::size_t>(field.slot)] = decode(*field.scalar, bytes);
  } else if (field.is_string) {
    cursor.take(cursor.length());
  } else {
    walk(*field.structure, cursor, values);
  }
}

void walk(const Struct& structure, Cursor& cursor, std::vector<double>& values) {
  for (const Field& field : structure.fields) {
    if (!field.is_array) {
      walk_one(field, cursor, values);
      continue;
    }
    const std::size_t count = field.count ? *field.count : cursor.length();
    if (field.scalar) {
      if (count > cursor.left)
        throw Error(fmt::format("{}: a message is shorter than its definition says", cursor.type));
      cursor.take(count * size_of(*field.scalar));
    } else if (field.is_string || !field.structure->fields.empty()) {
      for (std::size_t i = 0; i < count; ++i) walk_one(field, cursor, values);
    }
  }
}

using Texts = std::map<std::string, std::string>;

// The parts of a full definition: the type itself first, then "MSG: package/Type" after each line of '='.
Texts split(const std::string& type, const std::string& definition) {
  Texts texts;
  std::istringstream lines(definition);
  std::string current = type;
  std::string line;
  while (std::getline(lines, line)) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.rfind("====", 0) == 0) continue;
    if (line.rfind("MSG: ", 0) == 0)
      current = line.substr(5);
    else
      texts[current] += line + '\n';
  }
  return texts;
}

class Parser {
 public:
  Parser(std::string type, const Texts& texts) : type_(std::move(type)), texts_(texts) {}

  std::shared_ptr<Struct> parse(const std::string& name, int depth = 0) {
    const auto text = texts_.find(name);
    if (text == texts_.end())
      throw Error(fmt::format("{}: the definition in the bag lacks the part {}", type_, name));
    if (depth > 20) throw Error(fmt::format("{}: the definition in the bag contains itself", type_));
    const std::string package = name.substr(0, name.find('/'));
    auto structure = std::make_shared<Struct>();
    std::istringstream lines(text->second);
    std::string line;
    while (std::getline(lines, line)) {
      line = line.substr(0, line.find('#'));
      std::istringstream words(line);
      std::string kind, field_name;
      if (!(words >> kind)) continue;
      if (!(words >> field_name)) throw Error(fmt::format("{}: '{}' is no field of a message", type_, line));
      if (line.find('=') != std::string::npos) continue;  // a constant is not transmitted
      structure->fields.push_back(field(kind, field_name, package, depth));
    }
    return structure;
  }

 private:
  Field field(std::string kind, const std::string& name, const std::string& package, int depth) {
    Field result;
    result.name = name;
    const auto bracket = kind.find('[');
    if (bracket != std::string::npos) {
      result.is_array = true;
      const std::string count = kind.substr(bracket + 1, kind.find(']') - bracket - 1);
      if (!count.empty()) {
        if (count.size() > 6 || count.find_first_not_of("0123456789") != std::string::npos)
          throw Error(fmt::format("{}: '{}' is no type of a field", type_, kind));
        result.count = static_cast<std::size_t>(std::stoul(count));
      }
      kind.resize(bracket);
    }
    const auto scalar = scalars().find(kind);
    if (scalar != scalars().end()) {
      result.scalar = scalar->second;
    } else if (kind == "string") {
      result.is_string = true;
    } else if (kind == "time" || kind == "duration") {
      const Scalar part = kind == "time" ? Scalar::uint32 : Scalar::int32;
      result.structure = std::make_shared<Struct>();
      for (const char* half : {"secs", "nsecs"}) {
        Field time;
        time.name = half;
        time.scalar = part;
        result.structure->fields.push_back(time);
      }
    } else {
      if (kind == "Header") kind = "std_msgs/Header";
      if (kind.find('/') == std::string::npos) kind = package + '/' + kind;
      result.structure = parse(kind, depth + 1);
    }
    return result;
  }

  std::string type_;
  const Texts& texts_;
};

bool assign(Struct& structure, const std::string& path, int slot) {
  const auto dot = path.find('.');
  for (Field& field : structure.fields) {
    if (field.name != path.substr(0, dot) || field.is_array) continue;
    if (dot == std::string::npos) {
      if (!field.scalar) return false;
      field.slot = slot;
      return true;
    }
    return field.structure && assign(*field.structure, path.substr(dot + 1), slot);
  }
  return false;
}

}  // namespace

struct MessageDefinition::Impl {
  std::string type;
  std::shared_ptr<Struct> root;
  std::size_t slots = 0;
};

MessageDefinition::MessageDefinition(const std::string& type, const std::string& definition,
                                     const std::vector<std::string>& fields)
    : impl_(std::make_unique<Impl>()) {
  impl_->type = type;
  impl_->slots = fields.size();
  const Texts texts = split(type, definition);
  impl_->root = Parser(type, texts).parse(type);
  for (std::size_t i = 0; i < fields.size(); ++i)
    if (!assign(*impl_->root, fields[i], static_cast<int>(i)))
      throw Error(fmt::format("{}: has no number '{}'", type, fields[i]));
}

MessageDefinition::~MessageDefinition() = default;
MessageDefinition::MessageDefinition(MessageDefinition&&) noexcept = default;
MessageDefinition& MessageDefinition::operator=(MessageDefinition&&) noexcept = default;

std::vector<double> MessageDefinition::read(const std::uint8_t* data, std::size_t size) const {
  std::vector<double> values(impl_->slots, 0.0);
  Cursor cursor{data, size, impl_->type};
  walk(*impl_->root, cursor, values);
  if (cursor.left != 0)
    throw Error(fmt::format("{}: a message is longer than its definition says", impl_->type));
  return values;
}

}  // namespace wheel_twin::logs
