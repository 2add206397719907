#include "support/picture/unpacked_corpus.h"

#include <cstdlib>
#include <system_error>

namespace tessera::test {

std::optional<CorpusFolder> find_corpus(const std::string& name) {
  const std::filesystem::path in_place = std::filesystem::path("../shared/scenes") / name;
  std::error_code error;
  if (std::filesystem::is_directory(in_place, error)) return CorpusFolder(in_place);
  const std::string archive = in_place.string() + ".tar.xz";
  if (!std::filesystem::is_regular_file(archive, error)) return std::nullopt;
  auto folder = std::make_unique<support::TempDir>();
  const std::string command = "tar -xJf '" + archive + "' -C '" + folder->path().string() + "'";
  const std::filesystem::path unpacked = folder->path() / in_place.filename();
  if (std::system(command.c_str()) != 0 || !std::filesystem::is_directory(unpacked, error))
    return std::nullopt;
  return CorpusFolder(std::move(folder), unpacked);
}

}  // namespace tessera::test
