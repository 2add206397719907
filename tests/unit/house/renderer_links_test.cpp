// A program that links every room of the renderer but build/, which reads messages: what else comes along?
#include <gtest/gtest.h>
#include <link.h>

#include <string>
#include <vector>

namespace {

std::vector<std::string> loaded_libraries() {
  std::vector<std::string> paths;
  dl_iterate_phdr(
      [](dl_phdr_info* library, std::size_t, void* result) {
        static_cast<std::vector<std::string>*>(result)->emplace_back(library->dlpi_name);
        return 0;
      },
      &paths);
  return paths;
}

bool is_loaded(const std::string& name) {
  for (const std::string& path : loaded_libraries()) {
    if (path.find("/lib" + name + ".so") != std::string::npos) return true;
  }
  return false;
}

TEST(RendererLinks, NeitherProtobufNorOpenSslNorGrpc) {
  for (const char* name : {"protobuf", "crypto", "ssl", "grpc", "grpc++"}) {
    EXPECT_FALSE(is_loaded(name)) << "a room of the renderer links lib" << name;
  }
}

TEST(RendererLinks, TheTestSeesWhatIsLinked) {
  // Embree is linked by accel/, zstd by the results' bytes: both must show, although nothing here calls them.
  EXPECT_TRUE(is_loaded("zstd"));
  EXPECT_TRUE(is_loaded("embree3") || is_loaded("embree4"));
}

}  // namespace
