#include "soak/slurm/slurm_cluster.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <pwd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <stdexcept>
#include <thread>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace tessera::cluster {
namespace {

constexpr char kMunged[] = "/usr/sbin/munged";
constexpr char kController[] = "/usr/sbin/slurmctld";
constexpr char kNodeDaemon[] = "/usr/sbin/slurmd";
constexpr char kCommands[] = "/usr/bin/";
constexpr std::chrono::seconds kCommandPatience{60};
constexpr std::chrono::milliseconds kPoll{200};

/// Free ports, all different. Slurm takes no port 0, so another program may take one before Slurm does.
std::vector<int> free_ports(std::size_t count) {
  std::vector<int> sockets, ports;
  for (std::size_t i = 0; i < count; ++i) {
    sockets.push_back(::socket(AF_INET, SOCK_STREAM, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_ANY);
    socklen_t size = sizeof(address);
    if (::bind(sockets.back(), reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        ::getsockname(sockets.back(), reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      throw std::runtime_error("no free port");
    }
    ports.push_back(ntohs(address.sin_port));
  }
  for (const int socket : sockets) ::close(socket);
  return ports;
}

void write_key(const std::filesystem::path& file) {
  std::random_device device;
  {
    std::ofstream out(file, std::ios::binary);
    for (int i = 0; i < 1024; ++i) out.put(static_cast<char>(device()));
  }
  std::filesystem::permissions(file, std::filesystem::perms::owner_read);
}

void write_configuration(const std::filesystem::path& directory) {
  const std::vector<int> ports = free_ports(3);
  const std::string user = ::getpwuid(::getuid())->pw_name, at = directory.string();
  const unsigned cpus = std::max(1U, std::thread::hardware_concurrency());
  std::ofstream out(directory / "slurm.conf");
  out << "ClusterName=tessera\nSlurmctldHost=localhost\nSlurmctldPort=" << ports[0] << "\nSlurmUser=" << user
      << "\nSlurmdUser="
      << user
      // A requeued job waits until the credentials of its first run have expired.
      << "\nAuthType=auth/munge\nAuthInfo=cred_expire=5,socket=" << at << "/munge.socket\nCredType=cred/munge"
      << "\nStateSaveLocation=" << at << "/state\nSlurmdSpoolDir=" << at
      << "/spool-%n\nSlurmctldPidFile=" << at << "/slurmctld.pid\nSlurmdPidFile=" << at
      << "/slurmd-%n.pid\nSlurmctldLogFile=" << at << "/slurmctld.log\nSlurmdLogFile=" << at
      << "/slurmd-%n.log\nProctrackType=proctrack/linuxproc"
      << "\nTaskPlugin=task/none\nMpiDefault=none\nSwitchType=switch/none\nJobAcctGatherType=jobacct_gather/"
         "none"
      << "\nAccountingStorageType=accounting_storage/none\nSelectType=select/"
         "cons_tres\nSelectTypeParameters=CR_Core"
      << "\nPreemptType=preempt/partition_prio\nPreemptMode=REQUEUE\nKillWait=5\nReturnToService=2\n";
  for (int i = 0; i < 2; ++i) {
    out << "NodeName=" << (i == 0 ? "one" : "two")
        << " NodeHostname=localhost NodeAddr=127.0.0.1 Port=" << ports[i + 1] << " CPUs=" << cpus
        << " State=UNKNOWN\n";
  }
  out << "PartitionName=low Nodes=ALL Default=YES PriorityTier=1 MaxTime=INFINITE State=UP\n"
      << "PartitionName=high Nodes=ALL PriorityTier=10 PreemptMode=OFF MaxTime=INFINITE State=UP\n";
}

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

std::string SlurmCluster::missing() {
  std::string names;
  for (const char* const program : {kMunged, kController, kNodeDaemon}) {
    if (!std::filesystem::exists(program)) absl::StrAppend(&names, names.empty() ? "" : " ", program);
  }
  return names;
}

SlurmCluster::SlurmCluster() {
  const std::filesystem::path& at = directory_.path();
  for (const char* const name : {"state", "spool-one", "spool-two"})
    std::filesystem::create_directory(at / name);
  write_key(at / "munge.key");
  write_configuration(at);
  const auto start = [&](std::vector<std::string> command) {
    daemons_.push_back(std::make_unique<support::Process>(std::move(command)));
  };
  const std::string directory = at.string(), configuration = (at / "slurm.conf").string();
  // --force: a directory under /tmp is no place for a key that is worth something.
  start({kMunged, "--foreground", "--force", "--key-file=" + directory + "/munge.key",
         "--socket=" + directory + "/munge.socket", "--pid-file=" + directory + "/munged.pid",
         "--log-file=" + directory + "/munged.log", "--seed-file=" + directory + "/munge.seed"});
  start({kController, "-D", "-f", configuration});
  start({kNodeDaemon, "-D", "-f", configuration, "-N", "one"});
  start({kNodeDaemon, "-D", "-f", configuration, "-N", "two"});

  const auto deadline = std::chrono::steady_clock::now() + kCommandPatience;
  const auto idle = [&] {
    const std::string nodes = execute({"sinfo", "-h", "-N", "-p", "low", "-t", "idle"}).out;
    return std::count(nodes.begin(), nodes.end(), '\n') == 2;
  };
  while (!idle()) {
    if (std::chrono::steady_clock::now() > deadline) {
      throw std::runtime_error(absl::StrCat("Slurm's nodes are not idle\n", text_of(at / "munged.log"),
                                            text_of(at / "slurmctld.log"), text_of(at / "slurmd-one.log")));
    }
    std::this_thread::sleep_for(kPoll);
  }
}

SlurmCluster::~SlurmCluster() {
  run({"scancel", "--state=PENDING"});
  run({"scancel", "--state=RUNNING"});
  const auto deadline = std::chrono::steady_clock::now() + kCommandPatience;
  while (!run({"squeue", "-h"}).empty() && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(kPoll);
  }
  // In the order opposite to that of their start.
  while (!daemons_.empty()) {
    daemons_.back()->send_signal(SIGTERM);
    daemons_.back()->wait(std::chrono::seconds{10});
    daemons_.pop_back();
  }
}

support::Finished SlurmCluster::execute(std::vector<std::string> command,
                                        std::vector<std::string> environment) const {
  command.front().insert(0, kCommands);
  environment.push_back("SLURM_CONF=" + (directory_.path() / "slurm.conf").string());
  return support::run_program(std::move(command), kCommandPatience, std::move(environment));
}

std::string SlurmCluster::run(std::vector<std::string> command, std::vector<std::string> environment) const {
  const support::Finished finished = execute(command, std::move(environment));
  EXPECT_EQ(finished.status.code, 0) << command.front() << ": " << finished.err;
  return finished.out;
}

std::string SlurmCluster::submit(std::vector<std::string> arguments,
                                 std::vector<std::string> environment) const {
  std::vector<std::string> command{"sbatch", "--parsable"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  std::string id = run(std::move(command), std::move(environment));
  id.erase(id.find_last_not_of('\n') + 1);
  return id;
}

/// The value of `NAME=VALUE` in what Slurm tells of a job; empty for a job that it has forgotten.
std::string SlurmCluster::field(const std::string& job, const std::string& name) const {
  const support::Finished shown = execute({"scontrol", "--oneliner", "show", "job", job});
  const std::vector<std::string> words = absl::StrSplit(shown.out, ' ');
  for (const std::string& word : words) {
    if (word.starts_with(name + "=")) return word.substr(name.size() + 1);
  }
  return {};
}

std::string SlurmCluster::state_of(const std::string& job) const { return field(job, "JobState"); }

bool SlurmCluster::is_over(const std::string& job) const {
  const std::string state = state_of(job);
  return state != "PENDING" && state != "CONFIGURING" && state != "RUNNING" && state != "COMPLETING" &&
         state != "REQUEUED" && state != "PREEMPTED";
}

std::optional<JobEnd> SlurmCluster::wait_for_end(const std::string& job,
                                                 std::chrono::seconds patience) const {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (!is_over(job)) {
    if (std::chrono::steady_clock::now() > deadline) return std::nullopt;
    std::this_thread::sleep_for(kPoll);
  }
  return JobEnd{.state = state_of(job), .exit_code = std::atoi(field(job, "ExitCode").c_str())};
}

}  // namespace tessera::cluster
