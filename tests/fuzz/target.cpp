#include "fuzz/target.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace tessera::fuzz {
namespace {

/// A folder that goes away with the process.
class Scratch {
 public:
  Scratch() {
    std::string folder = (std::filesystem::temp_directory_path() / "tessera-fuzz-XXXXXX").string();
    require(mkdtemp(folder.data()) != nullptr, "no folder for scratch files");
    folder_ = folder;
  }
  ~Scratch() {
    std::error_code error;
    std::filesystem::remove_all(folder_, error);
  }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

}  // namespace

void require(bool promise, const char* what) {
  if (promise) return;
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

std::vector<char> exact(std::string_view bytes) { return {bytes.begin(), bytes.end()}; }

std::string scratch_file(const std::string& name, std::string_view bytes) {
  static const Scratch scratch;
  const std::filesystem::path path = scratch.folder() / name;
  // A fresh file each time: writing over the old one makes some file systems wait for the disk.
  std::filesystem::remove(path);
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return path.string();
}

std::string mutate_bytes(std::string bytes, std::mt19937& random) {
  static const std::vector<std::string> kNasty = {"nan",
                                                  "-1",
                                                  "4294967296",
                                                  "1e308",
                                                  "99999999999999999999",
                                                  "\"",
                                                  "[",
                                                  "]",
                                                  "#",
                                                  "\\",
                                                  "\n",
                                                  std::string(1, '\0'),
                                                  "\xff\xff\xff\xff",
                                                  "AttributeEnd",
                                                  "WorldBegin",
                                                  "ObjectEnd",
                                                  "Include \"pbrt.pbrt\"",
                                                  "\"integer indices\"",
                                                  "0",
                                                  "{",
                                                  "}"};
  const auto pick = [&](std::size_t below) { return below == 0 ? 0 : random() % below; };
  for (std::size_t edits = 1 + pick(4); edits > 0; --edits) {
    const std::size_t at = pick(bytes.size() + 1);
    const std::size_t length = pick(std::min<std::size_t>(16, bytes.size() - at) + 1);
    switch (pick(6)) {
      case 0:
        if (at < bytes.size()) bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes.erase(at, length);
        break;
      case 2:
        bytes.insert(pick(bytes.size() + 1), bytes.substr(at, length));
        break;
      case 3:
        bytes.replace(at, length, kNasty[pick(kNasty.size())]);
        break;
      case 4:
        bytes.insert(at, kNasty[pick(kNasty.size())]);
        break;
      case 5:
        if (pick(8) == 0) bytes.resize(at);
        break;
    }
  }
  return bytes;
}

std::vector<std::string> split_parts(std::string_view bytes) {
  std::vector<std::string> parts;
  while (bytes.size() >= sizeof(std::uint32_t)) {
    std::uint32_t size;
    std::memcpy(&size, bytes.data(), sizeof(size));
    bytes.remove_prefix(sizeof(size));
    const std::string_view part = bytes.substr(0, size);
    parts.emplace_back(part);
    bytes.remove_prefix(part.size());
  }
  return parts;
}

std::string join_parts(const std::vector<std::string>& parts) {
  std::string bytes;
  for (const std::string& part : parts) {
    const auto size = static_cast<std::uint32_t>(part.size());
    bytes.append(reinterpret_cast<const char*>(&size), sizeof(size)).append(part);
  }
  return bytes;
}

}  // namespace tessera::fuzz
