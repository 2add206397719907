#include "soak/load/farm_under_load.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "net/channel.h"
#include "store/journal.h"
#include "wire/digest.h"

namespace tessera::load {
namespace {

using std::chrono::milliseconds;

constexpr std::chrono::seconds kServerPatience{120};

/// A line of /proc/PID/status, in bytes.
std::uint64_t status_bytes(pid_t process, const std::string& name) {
  std::ifstream in("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(in, line);) {
    if (line.rfind(name + ":", 0) == 0) return std::stoull(line.substr(name.size() + 1)) * 1024;
  }
  return 0;
}

/// User and system time: the 14th and 15th field of /proc/PID/stat, counted behind the name in parentheses.
milliseconds cpu_time(pid_t process) {
  std::ifstream in("/proc/" + std::to_string(process) + "/stat");
  std::stringstream all;
  all << in.rdbuf();
  const std::string text = all.str();
  std::istringstream fields(text.substr(text.rfind(')') + 1));
  std::string skipped;
  for (int field = 3; field < 14; ++field) fields >> skipped;
  std::int64_t user = 0, system = 0;
  fields >> user >> system;
  return milliseconds((user + system) * 1000 / ::sysconf(_SC_CLK_TCK));
}

v1::JobSpec spec_of(const JobsOptions& options, std::size_t number, const std::string& scene) {
  const auto side = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(options.units))));
  v1::JobSpec spec;
  spec.mutable_farm()->set_name("load " + std::to_string(number));
  spec.mutable_farm()->set_user("user " + std::to_string(number % options.users));
  spec.mutable_content()->set_scene(wire::sha256_hex(scene));
  spec.mutable_farm()->add_blobs()->set_digest(spec.content().scene());
  spec.mutable_view()->set_width(side * options.tile_size);
  spec.mutable_view()->set_height(side * options.tile_size);
  spec.mutable_cut()->mutable_crop()->set_x1(spec.view().width());
  spec.mutable_cut()->mutable_crop()->set_y1(spec.view().height());
  spec.mutable_cut()->set_tile_size(options.tile_size);
  spec.mutable_cut()->set_samples_per_unit(64);
  spec.mutable_samples()->set_spp(64);
  return spec;
}

}  // namespace

void Progress::add(const std::string& job, std::uint32_t units) {
  jobs_[job].units = std::vector<std::atomic<bool>>(units);
  wanted_ += units;
}

void Progress::completed(const std::string& id, std::uint32_t unit) {
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return;
  Job& job = found->second;
  if (job.units.at(unit).exchange(true)) return;
  ++done_;
  if (++job.done != job.units.size()) return;
  std::vector<std::uint64_t> shares = this->shares();
  const std::lock_guard lock(mutex_);
  if (!one_is_done_.exchange(true)) shares_ = std::move(shares);
}

std::vector<std::uint64_t> Progress::shares() const {
  {
    const std::lock_guard lock(mutex_);
    if (!shares_.empty()) return shares_;
  }
  std::vector<std::uint64_t> shares;
  for (const auto& [id, job] : jobs_) shares.push_back(job.done);
  return shares;
}

std::string write_journal(const std::filesystem::path& data_dir, std::uint32_t units) {
  const auto sound = [](const absl::Status& status) {
    if (!status.ok()) throw std::runtime_error{status.ToString()};
  };
  std::filesystem::create_directories(data_dir / "results");
  auto journal = server::open_journal(data_dir);
  sound(journal.status());
  const v1::JobSpec spec = spec_of({.jobs = 1, .users = 1, .units = units, .tile_size = 1}, 0, "scene");
  const std::string id = "deadbeefdeadbeef";
  sound((*journal)->commit(
      {server::JobAdded{.id = id, .request_id = "request", .spec = spec.SerializeAsString()},
       server::JobBound{.id = id, .isa = "avx2"}}));
  const std::string stats = stub_stats(std::chrono::seconds(10)).SerializeAsString();
  constexpr std::uint32_t kBatch = 4096;
  for (std::uint32_t first = 0; first + 1 < units; first += kBatch) {
    std::vector<server::JournalEntry> entries;
    for (std::uint32_t unit = first; unit < std::min(first + kBatch, units - 1); ++unit) {
      const std::string payload = "result " + std::to_string(unit);
      entries.push_back(server::UnitDone{.job = id,
                                         .sequence = unit + 1,
                                         .units = {.first = unit},
                                         .digest = wire::sha256_hex(payload),
                                         .payload = payload,
                                         .stats = stats,
                                         .host = "host number " + std::to_string(unit % 1000)});
    }
    if (entries.size() == kBatch) {
      // Journals a sum, like a coordinator does now and then; only the part that tests look at.
      v1::JobCost sum;
      sum.mutable_stats()->set_samples(std::uint64_t{first + kBatch} *
                                       stub_stats(std::chrono::seconds(10)).samples());
      entries.push_back(
          server::JobStats{.id = id, .results = first + kBatch, .stats = sum.SerializeAsString()});
    }
    sound((*journal)->commit(entries));
  }
  return id;
}

FarmUnderLoad::FarmUnderLoad(std::string server_program, std::vector<std::string> arguments,
                             const std::function<void(const std::filesystem::path&)>& prepare,
                             std::vector<std::string> wrapper)
    : program_(std::move(server_program)), arguments_(std::move(arguments)), wrapper_(std::move(wrapper)) {
  if (prepare) prepare(directory_.path() / "data");
  start("127.0.0.1:0");
  auto channel = net::make_channel(address_);
  if (!channel.ok()) throw std::runtime_error{channel.status().ToString()};
  client_ = std::make_unique<client::FarmClient>(*std::move(channel),
                                                 client::FarmClientOptions{.address = address_});
}

void FarmUnderLoad::start(const std::string& listen) {
  std::vector<std::string> command = wrapper_;
  command.insert(command.end(),
                 {program_, "--listen", listen, "--data", (directory_.path() / "data").string()});
  command.insert(command.end(), arguments_.begin(), arguments_.end());
  process_ = std::make_unique<support::Process>(std::move(command));
  const std::optional<std::string> address = process_->wait_for_line("listening on ", kServerPatience);
  if (!address) throw std::runtime_error{"the coordinator does not listen:\n" + process_->err()};
  address_ = *address;
}

milliseconds FarmUnderLoad::kill_and_restart() {
  process_->kill();
  if (!process_->wait(kServerPatience)) throw std::runtime_error{"the coordinator does not die"};
  const auto begin = std::chrono::steady_clock::now();
  start(address_);
  return std::chrono::duration_cast<milliseconds>(std::chrono::steady_clock::now() - begin);
}

void FarmUnderLoad::stop() {
  process_->send_signal(SIGTERM);
  if (!process_->wait(kServerPatience)) throw std::runtime_error{"the coordinator does not end"};
}

ProcessUse FarmUnderLoad::use() const {
  return {.cpu = cpu_time(process_->id()),
          .resident_bytes = status_bytes(process_->id(), "VmRSS"),
          .peak_resident_bytes = status_bytes(process_->id(), "VmHWM")};
}

absl::StatusOr<std::vector<std::string>> FarmUnderLoad::submit(const JobsOptions& options,
                                                               Progress& progress) {
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < options.jobs; ++i) {
    // A coordinator looks into no scene.
    client::SceneBlob scene{.ref = {}, .bytes = "scene " + std::to_string(i % options.scenes), .file = ""};
    scene.ref.set_digest(wire::sha256_hex(scene.bytes));
    scene.ref.set_size_bytes(scene.bytes.size());
    if (const auto sent = client_->upload({&scene}, {}); !sent.ok()) return sent.status();
    const v1::JobSpec spec = spec_of(options, i, scene.bytes);
    const absl::StatusOr<std::string> id = client_->submit(spec, {.continued = "", .fresh = true}, {});
    if (!id.ok()) return id.status();
    const std::uint32_t side = spec.view().width() / spec.cut().tile_size();
    progress.add(*id, side * side);
    ids.push_back(*id);
  }
  return ids;
}

}  // namespace tessera::load
