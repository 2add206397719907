// Folders of the corpus that lies beside the project, some of them packed.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "support/process/temp_dir.h"

namespace tessera::test {

class CorpusFolder {
 public:
  explicit CorpusFolder(std::filesystem::path in_place) : path_(std::move(in_place)) {}
  CorpusFolder(std::unique_ptr<support::TempDir> unpacked, std::filesystem::path path)
      : unpacked_(std::move(unpacked)), path_(std::move(path)) {}

  const std::filesystem::path& path() const { return path_; }

 private:
  std::unique_ptr<support::TempDir> unpacked_;  // gone with this object
  std::filesystem::path path_;
};

/// "pbrt/classroom" or "mitsuba-suite", as it lies in ../shared/scenes or unpacked from the archive there;
/// nothing where neither is there.
std::optional<CorpusFolder> find_corpus(const std::string& name);

}  // namespace tessera::test
