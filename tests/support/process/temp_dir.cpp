#include "support/process/temp_dir.h"

#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>

namespace tessera::support {

TempDir::TempDir() {
  std::string name = (std::filesystem::temp_directory_path() / "tessera-test-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr)
    throw std::system_error{errno, std::generic_category(), "mkdtemp " + name};
  path_ = name;
}

TempDir::~TempDir() {
  std::error_code ignored;  // a test's verdict does not hang on it
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace tessera::support
