// A coordinator that dies and starts again: a real farm upon the model of a journal.
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>

#include "base/clock.h"
#include "scenario/model_journal.h"
#include "scenario/whole_farm/chance.h"
#include "service/farm/farm.h"
#include "store/blobs/blob_store.h"

namespace tessera::test {

/// For threads of one clock that take turns.
class MortalCoordinator {
  struct Life;

 public:
  /// `options` are those of each life. A commit takes up to `slowest_commit`.
  MortalCoordinator(base::Clock& clock, Chance& chance, server::FarmOptions options,
                    std::chrono::milliseconds slowest_commit);
  ~MortalCoordinator();

  absl::Status start();
  /// Ends this life: in peace, or with nothing more reaching the disk. Returns when everybody has left.
  void stop(bool power_fails);
  bool lives() const { return life_ != nullptr; }

  /// Somebody who calls; the coordinator does not go away meanwhile.
  class Visit {
   public:
    explicit Visit(std::shared_ptr<Life> life);
    ~Visit();
    Visit(Visit&& other) = default;
    /// Whether there is a coordinator.
    explicit operator bool() const { return life_ != nullptr; }
    server::Farm& farm() const;
    /// Requested when the coordinator's life ends.
    std::stop_token end() const;

   private:
    std::shared_ptr<Life> life_;
  };
  Visit visit() { return Visit{life_}; }

  server::BlobStore& blobs() { return *blobs_; }
  server::ModelJournal& journal() { return journal_; }

 private:
  class Disk;

  base::Clock& clock_;
  Chance& chance_;
  const server::FarmOptions options_;
  const std::chrono::milliseconds slowest_commit_;
  server::ModelJournal journal_;
  const std::unique_ptr<server::BlobStore> blobs_;
  std::shared_ptr<Life> life_;
};

}  // namespace tessera::test
