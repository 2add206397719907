// tessera init [FOLDER]: a scene to begin with, and a configuration.
#include <filesystem>
#include <iostream>
#include <memory>

#include "absl/strings/str_cat.h"
#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/setup/config_file.h"
#include "image/atomic_file.h"

#include "first_scene.h"  // kFirstScene: scenes/first-light/scene.textproto

namespace tessera::client {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFirstConfig =
    R"(# Settings of tessera; a command line goes before variables of the environment, these before this file.
# `tessera config show` tells what holds. Remove a # to make a line count.

# The coordinator, and the folder of your certificates.
# server = "10.0.0.1:7070"
# tls = "~/farm-tls/client-NAME"

# Options of all commands that have them.
[defaults]
# threads = 8

# Options of one command.
[render]
# spp = 64
# denoise = "regression"
)";

/// Writes a file that is not there yet.
absl::Status write_new(const std::string& path, const char* text) {
  std::error_code error;
  if (fs::exists(path, error)) {
    std::cout << "left as it is: " << path << '\n';
    return absl::OkStatus();
  }
  if (const fs::path folder = fs::path(path).parent_path(); !folder.empty())
    fs::create_directories(folder, error);
  const absl::Status status = replace_file_with(path, text);
  if (status.ok()) std::cout << "written: " << path << '\n';
  return status;
}

int run(const std::string& folder) {
  const std::string scene = (fs::path(folder) / "scene.textproto").string();
  absl::Status status = write_new(scene, kFirstScene);
  if (status.ok() && !config_path().empty()) status = write_new(config_path(), kFirstConfig);
  if (!status.ok()) return report(kIncomplete, std::string{status.message()});
  std::cout << "now: tessera render " << scene << " -o " << (fs::path(folder) / "picture.png").string()
            << " --spp 64\n";
  return kDone;
}

}  // namespace

void add_init_command(CommandLine& line) {
  auto folder = std::make_shared<std::string>("first-light");
  Command command = line.add_command("init", "Write a small scene and a configuration file to begin with");
  command.add("FOLDER", *folder, "of the scene; files that are there are left as they are").with_default();
  command.example("tessera init my-scene");
  command.does([folder](Interrupt&) { return run(*folder); });
}

}  // namespace tessera::client
