#include "support/unpacked_corpus.h"

#include <cstdlib>
#include <string>

namespace tessera::test {

std::unique_ptr<UnpackedSuite> unpack_mitsuba_suite() {
  const std::filesystem::path archive = "../shared/scenes/mitsuba-suite.tar.xz";
  std::error_code error;
  if (!std::filesystem::is_regular_file(archive, error)) return nullptr;
  auto suite = std::make_unique<UnpackedSuite>();
  const std::string command = "tar -xJf '" + archive.string() + "' -C '" + suite->path().parent_path().string() + "'";
  if (std::system(command.c_str()) != 0 || !std::filesystem::is_directory(suite->path(), error)) return nullptr;
  return suite;
}

}  // namespace tessera::test
