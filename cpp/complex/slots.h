// Things with numbers that survive every change they are not part of, and the way back to
// what was there when changes began.
#pragma once

#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "transect/cpp/complex/exact.h"

namespace transect::complex {

template <typename Item>
class Slots {
 public:
  // One more than the largest number in use.
  Id end() const { return static_cast<Id>(items_.size()); }
  bool has(Id id) const { return id < items_.size() && items_[id].has_value(); }
  std::size_t count() const { return items_.size() - free_.size(); }
  const Item& operator[](Id id) const { return *items_[id]; }

  // To be changed. References hold until something is added.
  Item& edit(Id id) {
    save(id);
    return *items_[id];
  }

  Id add(Item item) {
    if (free_.empty()) {
      items_.emplace_back();
      free_.push_back(end() - 1);
    }
    const Id id = free_.back();
    free_.pop_back();
    save(id);
    items_[id] = std::move(item);
    return id;
  }

  void remove(Id id) {
    save(id);
    items_[id].reset();
    free_.push_back(id);
  }

  // From now on what is there is remembered.
  void begin() {
    saved_.clear();
    saved_end_ = items_.size();
    saved_free_ = free_;
    is_saving_ = true;
  }

  // The numbers of all that was added, changed or removed since.
  std::vector<Id> touched() const {
    std::vector<Id> ids;
    for (const auto& [id, item] : saved_) ids.push_back(id);
    return ids;
  }

  void commit() {
    saved_.clear();
    is_saving_ = false;
  }

  void rollback() {
    for (auto& [id, item] : saved_) items_[id] = std::move(item);
    items_.resize(saved_end_);
    free_ = std::move(saved_free_);
    commit();
  }

 private:
  void save(Id id) {
    if (is_saving_) saved_.try_emplace(id, items_[id]);
  }

  std::vector<std::optional<Item>> items_;
  std::vector<Id> free_;
  std::unordered_map<Id, std::optional<Item>> saved_;
  std::vector<Id> saved_free_;
  std::size_t saved_end_ = 0;
  bool is_saving_ = false;
};

}  // namespace transect::complex
