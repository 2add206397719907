#include "integration/farm_under_test.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <condition_variable>
#include <fstream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <stop_token>
#include <thread>
#include <utility>

#include "image/exr.h"
#include "net/channel.h"
#include "wire/digest.h"

namespace tessera::integration {
namespace {

constexpr std::chrono::minutes kLongestWatch{10};

std::string& program_folder() {
  static std::string folder = TESSERA_BIN_DIR;
  return folder;
}

std::string program(const char* name) { return program_folder() + "/" + name; }

}  // namespace

void use_programs_of(const std::string& folder) { program_folder() = folder; }

std::string tessera_program() { return program("tessera"); }
std::string server_program() { return program("tessera-server"); }
std::string worker_program() { return program("tessera-worker"); }

support::Finished tessera(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), tessera_program());
  return support::run_program(std::move(arguments), kPatience);
}

std::string pixel_sha256(const std::filesystem::path& exr) {
  absl::StatusOr<client::Image> image = client::read_exr(exr.string());
  if (!image.ok()) {
    ADD_FAILURE() << image.status();
    return "";
  }
  std::sort(image->channels.begin(), image->channels.end(),
            [](const client::Channel& a, const client::Channel& b) { return a.name < b.name; });
  wire::Sha256 sha;
  for (const client::Channel& channel : image->channels) {
    sha.update(channel.name);
    sha.update({reinterpret_cast<const char*>(channel.values.data()), channel.values.size() * sizeof(float)});
  }
  return sha.finish_hex();
}

Arguments operator+(Arguments a, const Arguments& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Arguments in_many_units(const std::string& side, const std::string& spp, const std::string& tile) {
  return {"scenes/cornell-box/scene.pbrt",
          "--resolution",
          side + "x" + side,
          "--spp",
          spp,
          "--tile",
          tile,
          "--path-sharing",
          "off",
          "--quiet"};
}

const std::string& expected_hash(const Arguments& arguments) {
  static std::map<Arguments, std::string> hashes;
  const auto known = hashes.find(arguments);
  if (known != hashes.end()) return known->second;
  const support::TempDir directory;
  const std::string image = (directory.path() / "in-process.exr").string();
  const support::Finished done = tessera(Arguments{"render"} + arguments + Arguments{"-o", image});
  EXPECT_EQ(done.status.code, 0) << done.err;
  return hashes[arguments] = pixel_sha256(image);
}

double json_number(const std::filesystem::path& file, const std::string& name) {
  std::ifstream in{file};
  return nlohmann::json::parse(in).at(name).get<double>();
}

FarmUnderTest::FarmUnderTest(std::vector<std::string> wrapper, std::vector<std::string> environment,
                             const std::string& host, Arguments options)
    : wrapper_(std::move(wrapper)), environment_(std::move(environment)), options_(std::move(options)) {
  start_coordinator(host + ":0");
  client_ = new_client();
}

std::unique_ptr<client::FarmClient> FarmUnderTest::new_client() const {
  auto channel = net::make_channel(address_, {.allow_insecure = true});
  if (!channel.ok()) throw std::runtime_error{channel.status().ToString()};
  return std::make_unique<client::FarmClient>(*std::move(channel),
                                              client::FarmClientOptions{.address = address_});
}

void FarmUnderTest::start_coordinator(const std::string& listen) {
  coordinator_ = std::make_unique<support::Process>(
      wrapper_ +
          Arguments{server_program(), "--listen", listen, "--data", data_dir().string(), "--allow-insecure"} +
          options_,
      environment_);
  const std::optional<std::string> address = coordinator_->wait_for_line("listening on ", kPatience);
  if (!address) throw std::runtime_error{"the coordinator does not listen:\n" + coordinator_->err()};
  address_ = *address;
}

std::unique_ptr<support::Process> FarmUnderTest::start_worker(const WorkerSetup& setup) const {
  return std::make_unique<support::Process>(
      setup.wrapper +
          Arguments{worker_program(), "--server", setup.server.empty() ? address_ : setup.server, "--threads",
                    std::to_string(setup.threads), "--cache", setup.cache.string(), "--name", setup.name,
                    "--log-level", "debug", "--allow-insecure"} +
          setup.options,
      setup.environment);
}

support::Process& FarmUnderTest::add_worker(WorkerSetup setup) {
  const std::string number = std::to_string(workers_.size());
  if (setup.name.empty()) setup.name = "worker" + number;
  if (setup.cache.empty()) setup.cache = directory() / ("cache" + number);
  auto process = start_worker(setup);
  workers_.push_back({std::move(setup), std::move(process)});
  return *workers_.back().process;
}

support::Process& FarmUnderTest::add_worker(int threads, std::string name) {
  return add_worker(WorkerSetup{.threads = threads, .name = std::move(name)});
}

void FarmUnderTest::kill_worker(std::size_t index) {
  worker(index).kill();
  if (!worker(index).wait(kPatience)) throw std::runtime_error{"the worker does not die"};
}

support::Process& FarmUnderTest::restart_worker(std::size_t index) {
  workers_[index].process = start_worker(workers_[index].setup);
  return worker(index);
}

void FarmUnderTest::kill_coordinator() {
  coordinator_->kill();
  if (!coordinator_->wait(kPatience)) throw std::runtime_error{"the coordinator does not die"};
}

void FarmUnderTest::kill_and_restart_coordinator() {
  kill_coordinator();
  restart_coordinator();
}

void FarmUnderTest::kill_somebody(std::mt19937_64& random) {
  const auto victim = random() % (workers_.size() + 1);
  if (victim == workers_.size()) return kill_and_restart_coordinator();
  kill_worker(victim);
  restart_worker(victim);
}

std::vector<std::string> FarmUnderTest::on_farm(std::vector<std::string> arguments) const {
  arguments.insert(arguments.end(), {"--server", address_, "--allow-insecure"});
  return arguments;
}

std::string FarmUnderTest::submit_detached(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "submit");
  arguments.insert(arguments.end(), {"--detach", "--quiet"});
  const support::Finished done = tessera(on_farm(std::move(arguments)));
  EXPECT_EQ(done.status.code, 0) << done.err;
  const std::string prefix = "job ";
  if (done.out.rfind(prefix, 0) != 0) {
    ADD_FAILURE() << "no job id in: " << done.out;
    return "";
  }
  return done.out.substr(prefix.size(), done.out.find('\n') - prefix.size());
}

std::string FarmUnderTest::fetch_hash(const std::string& job_id) {
  const std::filesystem::path image = directory() / (job_id + ".exr");
  const support::Finished done = tessera(on_farm({"fetch", job_id, "-o", image.string(), "--quiet"}));
  EXPECT_EQ(done.status.code, 0) << done.err;
  return done.status.code == 0 ? pixel_sha256(image) : "";
}

v1::JobStatus FarmUnderTest::watch_until(const std::string& job_id,
                                         const std::function<bool(const v1::JobStatus&)>& enough,
                                         std::set<std::uint32_t>* acknowledged) {
  std::stop_source stop;
  v1::JobStatus reached;
  client::FarmClient::WatchHandlers handlers;
  if (acknowledged != nullptr) {
    handlers.result = [&](const v1::UnitResult& result) {
      acknowledged->insert(result.unit().index());
      return absl::OkStatus();
    };
  }
  handlers.status = [&](const v1::JobStatus& status) {
    if (stop.stop_requested()) return;
    reached = status;
    if (enough(status)) stop.request_stop();
  };
  const std::jthread limit{[&](std::stop_token over) {
    std::mutex mutex;
    std::unique_lock lock{mutex};
    std::condition_variable_any{}.wait_for(lock, over, kLongestWatch, [] { return false; });
    if (over.stop_requested()) return;
    ADD_FAILURE() << "job " << job_id << " does not get there:\n" << coordinator_->err();
    for (const Worker& worker : workers_) ADD_FAILURE() << worker.process->err();
    stop.request_stop();
  }};
  const absl::StatusOr<v1::JobStatus> status = client_->watch(job_id, handlers, stop.get_token());
  if (status.ok()) return *status;
  EXPECT_TRUE(absl::IsCancelled(status.status())) << status.status();
  return reached;
}

v1::JobStatus FarmUnderTest::watch_to_the_end(const std::string& job_id, int* retries) {
  for (;;) {
    v1::JobStatus end = watch_until(job_id, [](const v1::JobStatus&) { return false; });
    if (end.state() != v1::INCOMPLETE) return end;
    if (retries != nullptr) ++*retries;
    const auto retried = client_->retry(job_id, {});
    if (retried.ok()) continue;
    ADD_FAILURE() << "job " << job_id << " is not tried again";
    return end;
  }
}

}  // namespace tessera::integration
