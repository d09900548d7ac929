#include "logs/cmu_testbed_tables.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <set>

#include "base/error.h"

namespace wheel_twin::logs::cmu {
namespace {

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == ',')
      fields.emplace_back();
    else if (c != '\r')
      fields.back() += c;
  }
  return fields;
}

bool parse(const std::string& text, double& value) {
  const char* begin = text.data();
  const char* end = begin + text.size();
  while (begin != end && *begin == ' ') ++begin;
  const auto [stop, code] = std::from_chars(begin, end, value);
  return begin != end && code == std::errc() && stop == end && std::isfinite(value);
}

// A CSV with comment lines ('#'), a header line and rows of as many fields.
class Table {
 public:
  Table(std::string path, const std::set<std::string>& known, std::vector<std::string>& remarks)
      : path_(std::move(path)), stream_(path_) {
    if (!stream_) throw Error(fmt::format("{}: cannot be read", path_));
    std::string line;
    while (next_line(line) && (line.empty() || line[0] == '#')) {
    }
    names_ = fields_of(line);
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (!columns_.emplace(names_[i], i).second)
        throw Error(fmt::format("{}:{}: column '{}' appears twice", path_, number_, names_[i]));
      if (!known.count(names_[i]))
        remarks.push_back(fmt::format("{}: column '{}' is not known and not used", path_, names_[i]));
    }
    for (const std::string& name : known)
      if (!columns_.count(name))
        throw Error(fmt::format("{}:{}: column '{}' is missing", path_, number_, name));
  }

  bool next() {
    std::string line;
    do {
      if (!next_line(line)) return false;
    } while (line.empty() || line == "\r" || line[0] == '#');
    row_ = fields_of(line);
    if (row_.size() != names_.size())
      throw Error(fmt::format("{}:{}: {} fields where the header has {}", path_, number_, row_.size(),
                              names_.size()));
    return true;
  }

  const std::string& text(const std::string& column) const { return row_[columns_.at(column)]; }

  double number(const std::string& column) const {
    double value = 0.0;
    if (!parse(text(column), value))
      throw Error(
          fmt::format("{}:{}: {}: a number is expected, not '{}'", path_, number_, column, text(column)));
    return value;
  }

  std::optional<double> optional_number(const std::string& column) const {
    if (text(column).empty()) return std::nullopt;
    return number(column);
  }

  [[noreturn]] void fail(const std::string& column, const std::string& message) const {
    throw Error(fmt::format("{}:{}: {}: {}", path_, number_, column, message));
  }

 private:
  bool next_line(std::string& line) {
    ++number_;
    return static_cast<bool>(std::getline(stream_, line));
  }

  std::string path_;
  std::ifstream stream_;
  std::size_t number_ = 0;
  std::vector<std::string> names_;
  std::map<std::string, std::size_t> columns_;
  std::vector<std::string> row_;
};

bool is_day(const std::string& text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return false;
  for (const std::size_t i : {0, 1, 2, 3, 5, 6, 8, 9})
    if (text[i] < '0' || text[i] > '9') return false;
  return true;
}

bool is_plain_name(const std::string& text) {
  return !text.empty() && text.find("..") == std::string::npos && text[0] != '/' &&
         text.find('\\') == std::string::npos;
}

const std::set<std::string> run_columns = {
    "wheel",        "day",           "file",          "Vx_cmd_mm_s",
    "Vry_cmd_mm_s", "beta_deg",      "trial",         "slip",
    "Vx_mm_s",      "Vx_std",        "Vry_mm_s",      "Vry_std",
    "angle_deg",    "Fx_tractive_N", "Fx_std_N",      "Fy_lateral_N",
    "Fy_std_N",     "Fz_load_N",     "Fz_std_N",      "Fx_slope_N_s",
    "Fz_slope_N_s", "Fy_slope_N_s",  "sinkage_mm",    "sinkage_std_mm",
    "win_t0_s",     "win_t1_s",      "log_Z0_mm",     "log_start_epoch_local",
    "log_rows",     "log_rate_hz",   "log_duration_s"};

const std::set<std::string> plate_columns = {
    "file", "indenter",     "diameter_mm",    "t0_s",
    "t1_s", "z_surface_mm", "force_offset_n", "txt_clock_behind_utc_h"};

}  // namespace

std::vector<RunRow> read_runs(const std::string& path, std::vector<std::string>& remarks) {
  Table table(path, run_columns, remarks);
  std::vector<RunRow> rows;
  std::set<std::string> seen;
  while (table.next()) {
    RunRow row;
    row.wheel = table.text("wheel");
    if (row.wheel != "smooth" && row.wheel != "grouser")
      table.fail("wheel", fmt::format("smooth or grouser is expected, not '{}'", row.wheel));
    row.day = table.text("day");
    if (!is_day(row.day)) table.fail("day", fmt::format("a day YYYY-MM-DD is expected, not '{}'", row.day));
    row.file = table.text("file");
    if (!is_plain_name(row.file) || row.file.find('/') != std::string::npos)
      table.fail("file", fmt::format("'{}' is no name of a run", row.file));
    if (!seen.insert(row.wheel + '/' + row.day + '/' + row.file).second)
      table.fail("file", fmt::format("{} of {} is in the table twice", row.file, row.day));
    row.vry_command_mm_s = table.number("Vry_cmd_mm_s");
    row.beta_deg = table.number("beta_deg");
    row.angle_deg = table.number("angle_deg");
    row.slip = table.number("slip");
    if (row.slip < -1.0 || row.slip > 1.0) table.fail("slip", "is not between -1 and 1");
    row.vx_mm_s = table.number("Vx_mm_s");
    row.vry_mm_s = table.number("Vry_mm_s");
    row.tractive_n = {table.number("Fx_tractive_N"), table.number("Fx_std_N")};
    row.lateral_n = {table.number("Fy_lateral_N"), table.number("Fy_std_N")};
    row.load_n = {table.number("Fz_load_N"), table.number("Fz_std_N")};
    row.sinkage_mm = {table.number("sinkage_mm"), table.number("sinkage_std_mm")};
    row.window_start_s = table.number("win_t0_s");
    row.window_end_s = table.number("win_t1_s");
    if (row.window_start_s < 0.0 || row.window_end_s <= row.window_start_s)
      table.fail("win_t1_s", "the window does not end after it starts");
    row.z0_mm = table.number("log_Z0_mm");
    row.start_epoch_local = table.number("log_start_epoch_local");
    row.rate_hz = table.number("log_rate_hz");
    row.duration_s = table.number("log_duration_s");
    rows.push_back(row);
  }
  if (rows.empty()) throw Error(fmt::format("{}: has no runs", path));
  return rows;
}

std::vector<PlateRow> read_plates(const std::string& path, std::vector<std::string>& remarks) {
  Table table(path, plate_columns, remarks);
  std::vector<PlateRow> rows;
  while (table.next()) {
    PlateRow row;
    row.file = table.text("file");
    if (!is_plain_name(row.file))
      table.fail("file", fmt::format("'{}' is no name inside the data set", row.file));
    row.indenter = table.text("indenter");
    if (row.indenter != "plate" && row.indenter != "wheel_smooth" && row.indenter != "wheel_grouser" &&
        row.indenter != "rigid_floor")
      table.fail("indenter", fmt::format("'{}' is not known", row.indenter));
    row.diameter_mm = table.optional_number("diameter_mm");
    if ((row.indenter == "plate") != row.diameter_mm.has_value())
      table.fail("diameter_mm", "a plate has one, other indenters have none");
    row.stroke_start_s = table.number("t0_s");
    row.stroke_end_s = table.number("t1_s");
    if (row.stroke_end_s <= row.stroke_start_s) table.fail("t1_s", "the stroke does not end after it starts");
    row.z_surface_mm = table.optional_number("z_surface_mm");
    if ((row.indenter == "rigid_floor") == row.z_surface_mm.has_value())
      table.fail("z_surface_mm", "sand has a surface, a rigid floor has none");
    row.force_offset_n = table.number("force_offset_n");
    row.clock_behind_utc_h = table.number("txt_clock_behind_utc_h");
    rows.push_back(row);
  }
  return rows;
}

Kinematics read_kinematics(const std::string& path, std::vector<std::string>& remarks) {
  std::ifstream stream(path);
  if (!stream) throw Error(fmt::format("{}: cannot be read", path));
  Kinematics kinematics;
  std::size_t bad = 0, number = 0, first_bad = 0;
  std::string line;
  while (std::getline(stream, line)) {
    ++number;
    if (line.empty() || line == "\r") continue;
    const std::vector<std::string> fields = fields_of(line);
    std::array<double, 7> values{};
    bool good = fields.size() == values.size() || fields.size() == values.size() + 1;
    if (fields.size() == values.size() + 1) kinematics.has_eighth_column = true;
    for (std::size_t i = 0; good && i < values.size(); ++i) good = parse(fields[i], values[i]);
    const double controller = values[5] * 1e-3;
    good = good && (kinematics.controller_s.empty() || controller > kinematics.controller_s.back());
    if (!good) {
      if (bad++ == 0) first_bad = number;
      continue;
    }
    kinematics.x_mm.push_back(values[0]);
    kinematics.vx_mm_s.push_back(values[1]);
    kinematics.vry_mm_s.push_back(values[2]);
    kinematics.steering_deg.push_back(values[3]);
    kinematics.z_mm.push_back(values[4]);
    kinematics.controller_s.push_back(controller);
    kinematics.computer_s.push_back(values[6]);
  }
  if (kinematics.size() < 10)
    throw Error(fmt::format("{}: {} good rows of 7 numbers (X, Vx, Vry, angle, Z, controller ms, computer s)",
                            path, kinematics.size()));
  if (bad > 0)
    remarks.push_back(
        fmt::format("{}: {} rows left out, the first is line {}: not 7 finite numbers in the order of the "
                    "controller clock",
                    path, bad, first_bad));
  return kinematics;
}

}  // namespace wheel_twin::logs::cmu
