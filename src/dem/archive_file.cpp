// The HDF5 side of Archive: groups /arrays, /numbers, /texts, and at the root the attributes format, version,
// kind and sha256 of the content.
#include <fcntl.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <utility>

#include "base/atomic_file.h"
#include "base/error.h"
#include "dem/archive.h"

namespace wheel_twin::dem {
namespace {

constexpr const char* format_name = "wheel_twin archive";

// An HDF5 identifier that closes itself.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle(hid_t id, Close how) : id_(id), close_(how) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }  // NOLINT(google-explicit-constructor): the C API takes hid_t
  bool ok() const { return id_ >= 0; }
  bool finish() { return close_(std::exchange(id_, -1)) >= 0; }

 private:
  hid_t id_;
  Close close_;
};

std::array<hid_t, 6> native_types() {
  return {H5T_NATIVE_DOUBLE, H5T_NATIVE_FLOAT, H5T_NATIVE_INT32,
          H5T_NATIVE_UINT32, H5T_NATIVE_INT64, H5T_NATIVE_UINT64};
}

std::array<hid_t, 6> file_types() {
  return {H5T_IEEE_F64LE, H5T_IEEE_F32LE, H5T_STD_I32LE, H5T_STD_U32LE, H5T_STD_I64LE, H5T_STD_U64LE};
}

// HDF5 prints its error stack on standard error unless told not to; one line from us is enough.
void silence() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

bool write_text(hid_t place, const std::string& name, const std::string& value) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, value.size() + 1);
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate2(place, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute.ok() && H5Awrite(attribute, type, value.c_str()) >= 0;
}

bool write_number(hid_t place, const std::string& name, double value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate2(place, name.c_str(), H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  return attribute.ok() && H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value) >= 0;
}

bool write_array(hid_t group, const std::string& name, const Array& array) {
  return std::visit(
      [&](const auto& values) {
        const std::array<hsize_t, 2> shape{values.size() / array.columns, array.columns};
        const Handle space(H5Screate_simple(array.columns == 1 ? 1 : 2, shape.data(), nullptr), H5Sclose);
        const std::size_t type = array.data.index();
        const Handle set(
            H5Dcreate2(group, name.c_str(), file_types()[type], space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
            H5Dclose);
        return set.ok() && (values.empty() || H5Dwrite(set, native_types()[type], H5S_ALL, H5S_ALL,
                                                       H5P_DEFAULT, values.data()) >= 0);
      },
      array.data);
}

std::string read_text(hid_t place, const std::string& name) {
  const Handle attribute(H5Aopen(place, name.c_str(), H5P_DEFAULT), H5Aclose);
  if (!attribute.ok()) return {};
  const Handle type(H5Aget_type(attribute), H5Tclose);
  const std::size_t size =
      H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0 ? H5Tget_size(type) : 0;
  std::string value(size, '\0');
  if (size == 0 || H5Aread(attribute, type, value.data()) < 0) return {};
  return value.substr(0, value.find('\0'));
}

double read_number(hid_t place, const std::string& name) {
  double value = 0.0;
  const Handle attribute(H5Aopen(place, name.c_str(), H5P_DEFAULT), H5Aclose);
  if (!attribute.ok() || H5Aread(attribute, H5T_NATIVE_DOUBLE, &value) < 0) return 0.0;
  return value;
}

std::vector<std::string> attribute_names(hid_t place) {
  std::vector<std::string> names;
  H5Aiterate2(
      place, H5_INDEX_NAME, H5_ITER_INC, nullptr,
      [](hid_t, const char* name, const H5A_info_t*, void* list) -> herr_t {
        static_cast<std::vector<std::string>*>(list)->emplace_back(name);
        return 0;
      },
      &names);
  return names;
}

std::vector<std::string> dataset_names(hid_t group) {
  std::vector<std::string> names;
  H5Literate(
      group, H5_INDEX_NAME, H5_ITER_INC, nullptr,
      [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
        static_cast<std::vector<std::string>*>(list)->emplace_back(name);
        return 0;
      },
      &names);
  return names;
}

template <std::size_t index>
bool read_values(hid_t set, hsize_t count, Array& array) {
  std::variant_alternative_t<index, Array::Data> values(count);
  const bool good =
      count == 0 || H5Dread(set, native_types()[index], H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0;
  array.data = std::move(values);
  return good;
}

bool read_array(hid_t group, const std::string& name, Array& array) {
  const Handle set(H5Dopen2(group, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set.ok()) return false;
  const Handle space(H5Dget_space(set), H5Sclose);
  std::array<hsize_t, 2> shape{0, 1};
  const int dimensions = H5Sget_simple_extent_ndims(space);
  if (dimensions < 1 || dimensions > 2) return false;
  H5Sget_simple_extent_dims(space, shape.data(), nullptr);
  array.columns = shape[1];
  const hsize_t count = shape[0] * shape[1];
  const Handle type(H5Dget_type(set), H5Tclose);
  const auto known = file_types();
  if (H5Dget_storage_size(set) != count * H5Tget_size(type))
    return false;  // a lie about the size: do not allocate
  if (H5Tequal(type, known[0]) > 0) return read_values<0>(set, count, array);
  if (H5Tequal(type, known[1]) > 0) return read_values<1>(set, count, array);
  if (H5Tequal(type, known[2]) > 0) return read_values<2>(set, count, array);
  if (H5Tequal(type, known[3]) > 0) return read_values<3>(set, count, array);
  if (H5Tequal(type, known[4]) > 0) return read_values<4>(set, count, array);
  if (H5Tequal(type, known[5]) > 0) return read_values<5>(set, count, array);
  return false;
}

void sync_to_disk(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool good = file >= 0 && fsync(file) == 0;
  if (file >= 0) close(file);
  if (!good) throw Error(fmt::format("{}: cannot be written to disk", path));
}

bool write_content(hid_t file, const std::string& kind, const Archive& archive) {
  bool good = write_text(file, "format", format_name) && write_number(file, "version", archive_version) &&
              write_text(file, "kind", kind) && write_text(file, "sha256", archive.hash());
  const Handle arrays(H5Gcreate2(file, "arrays", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  const Handle numbers(H5Gcreate2(file, "numbers", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  const Handle texts(H5Gcreate2(file, "texts", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  for (const auto& [name, array] : archive.arrays()) good = good && write_array(arrays, name, array);
  for (const auto& [name, value] : archive.numbers()) good = good && write_number(numbers, name, value);
  for (const auto& [name, value] : archive.texts()) good = good && write_text(texts, name, value);
  return good;
}

/// HDF5's file that lives in memory.
Handle memory_access() {
  constexpr std::size_t increment = 1 << 20;
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_core(access, increment, 0);
  return access;
}

}  // namespace

class ArchiveReader {
 public:
  static Archive read(const Handle& file, const std::string& path, const std::string& kind) {
    if (!file.ok()) throw Error(fmt::format("{}: is not an HDF5 file or was cut short", path));
    if (read_text(file, "format") != format_name)
      throw Error(fmt::format("{}: is not a file of this program", path));
    const double version = read_number(file, "version");
    if (version != archive_version)
      throw Error(fmt::format("{}: has version {}, this program reads version {}: make it again", path,
                              version, int{archive_version}));
    const std::string found_kind = read_text(file, "kind");
    if (found_kind != kind)
      throw Error(fmt::format("{}: holds a {}, a {} is expected", path, found_kind, kind));

    Archive archive;
    archive.source_ = path;
    const Handle arrays(H5Gopen2(file, "arrays", H5P_DEFAULT), H5Gclose);
    const Handle numbers(H5Gopen2(file, "numbers", H5P_DEFAULT), H5Gclose);
    const Handle texts(H5Gopen2(file, "texts", H5P_DEFAULT), H5Gclose);
    if (!arrays.ok() || !numbers.ok() || !texts.ok()) throw Error(fmt::format("{}: is damaged", path));
    for (const std::string& name : dataset_names(arrays)) {
      Array array;
      if (!read_array(arrays, name, array)) throw Error(fmt::format("{}: {}: is damaged", path, name));
      archive.arrays_[name] = std::move(array);
    }
    for (const std::string& name : attribute_names(numbers))
      archive.numbers_[name] = read_number(numbers, name);
    for (const std::string& name : attribute_names(texts)) archive.texts_[name] = read_text(texts, name);
    if (archive.hash() != read_text(file, "sha256"))
      throw Error(fmt::format(
          "{}: its content does not have the checksum it was written with: the file is damaged", path));
    return archive;
  }
};

void write_archive(const std::string& path, const std::string& kind, const Archive& archive) {
  silence();
  AtomicFile target(path);
  Handle file(H5Fcreate(target.path().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
  if (!file.ok()) throw Error(fmt::format("{}: cannot be written", path));
  bool good = write_content(file, kind, archive);
  good = file.finish() && good;
  if (!good) throw Error(fmt::format("{}: cannot be written", path));
  sync_to_disk(target.path());
  target.commit();
}

Archive read_archive(const std::string& path, const std::string& kind) {
  silence();
  if (!std::filesystem::exists(path)) throw Error(fmt::format("{}: does not exist", path));
  const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  return ArchiveReader::read(file, path, kind);
}

std::vector<std::uint8_t> archive_bytes(const std::string& kind, const Archive& archive) {
  silence();
  const Handle access = memory_access();
  const Handle file(H5Fcreate("archive", H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose);
  if (!file.ok() || !write_content(file, kind, archive) || H5Fflush(file, H5F_SCOPE_GLOBAL) < 0)
    throw Error(fmt::format("a {} cannot be packed into a message", kind));
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(H5Fget_file_image(file, nullptr, 0)));
  if (H5Fget_file_image(file, bytes.data(), bytes.size()) < 0)
    throw Error(fmt::format("a {} cannot be packed into a message", kind));
  return bytes;
}

Archive archive_from_bytes(const std::vector<std::uint8_t>& bytes, const std::string& kind,
                           const std::string& source) {
  silence();
  const Handle access = memory_access();
  std::vector<std::uint8_t> copy = bytes;  // the library takes no const pointer
  H5Pset_file_image(access, copy.data(), copy.size());
  const Handle file(H5Fopen("archive", H5F_ACC_RDONLY, access), H5Fclose);
  return ArchiveReader::read(file, source, kind);
}

}  // namespace wheel_twin::dem
