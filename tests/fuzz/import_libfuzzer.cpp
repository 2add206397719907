// libFuzzer entry: the first byte chooses what the rest is fed to.
#include <cstddef>
#include <cstdint>
#include <filesystem>

#include "fuzz/import_targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data + 1), size - 1);
  static const std::string folder = std::filesystem::temp_directory_path().string();
  switch (data[0] % 7) {
    case 0:
      tessera::fuzz::try_ply(bytes);
      break;
    case 1:
      tessera::fuzz::try_pbrt(bytes, folder.c_str());
      break;
    case 2:
      tessera::fuzz::try_mitsuba(bytes, folder.c_str());
      break;
    case 3:
      tessera::fuzz::try_obj(bytes);
      break;
    case 4:
      tessera::fuzz::try_serialized(bytes);
      break;
    case 5:
      tessera::fuzz::try_volume(bytes);
      break;
    default:
      tessera::fuzz::try_text_scene(bytes, folder.c_str());
      break;
  }
  return 0;
}
