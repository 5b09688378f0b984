#include "amb_rotor/ros/analysis_node.hpp"

#include "amb_rotor/ros/node_setup.hpp"

namespace amb_rotor {

AnalysisNode::AnalysisNode(const ros::NodeHandle& nodes, const ros::NodeHandle& own) : nodes_(nodes) {
  options_.turns = integerOr(own, "turns", options_.turns);
  options_.longest = numberOr(own, "longest", options_.longest);
  options_.points = integerOr(own, "points", options_.points);
  options_.max_order = integerOr(own, "max_order", options_.max_order);
  options_.tolerance = numberOr(own, "tolerance", options_.tolerance);
  model_subscriber_ = nodes_.subscribe("rotor/model", 10, &AnalysisNode::takeInfo, this);
  contact_subscriber_ =
      nodes_.subscribe("auxiliary_bearing/contact", keep_all, &AnalysisNode::takeContact, this);
  state_subscriber_ = nodes_.subscribe("rotor/state", keep_all, &AnalysisNode::takeState, this);
  status_subscriber_ =
      nodes_.subscribe<PlantStatus>("rotor/status", 10, [this](const PlantStatus::ConstPtr& status) {
        if (status->state == PlantStatus::RUNNING || (info_ != nullptr && status->run != info_->run)) return;
        ending_ = true;
        // a run that ended otherwise never published the step at which it did
        last_step_ =
            status->state == PlantStatus::FINISHED || status->step == 0 ? status->step : status->step - 1;
        finishIfDone();
      });
  // last: who waits for these topics knows that the others are heard
  point_publisher_ = nodes_.advertise<SectionPoint>("analysis/poincare", keep_all);
  spectrum_publisher_ = nodes_.advertise<FullSpectrum>("analysis/spectrum", keep_all);
  orbit_publisher_ = nodes_.advertise<OrbitAnalysis>("analysis/orbit", keep_all, true);
}

void AnalysisNode::takeInfo(const ModelInfo::ConstPtr& info) {
  if (info_ != nullptr && info_->run == info->run) return;
  info_ = info;
  ends_.clear();
  for (int end = 0; end < 2; ++end) ends_.emplace_back(end, *info, options_);
  joined_ = lost_ = 0;
  ending_ = finished_ = false;
  join();
}

void AnalysisNode::takeState(const RotorState::ConstPtr& state) {
  states_.emplace(state->step, state);  // a step published again is the same
  join();
}

void AnalysisNode::takeContact(const ContactForces::ConstPtr& contact) {
  if (contact->ends.size() != 2) return;
  contacts_.emplace(contact->step, contact);
  join();
}

void AnalysisNode::join() {
  if (info_ == nullptr) return;
  const auto foreign = [&](const auto& entry) {
    return entry.second->run != info_->run || entry.second->model_hash != info_->model_hash ||
           entry.first < joined_;
  };
  while (!states_.empty() && foreign(*states_.begin())) states_.erase(states_.begin());
  while (!contacts_.empty() && foreign(*contacts_.begin())) contacts_.erase(contacts_.begin());
  BlockAnalysis::Output out;
  while (!states_.empty() && !contacts_.empty()) {
    const auto state = states_.begin();
    const auto contact = contacts_.begin();
    if (contact->first < state->first) {  // an answer to what we never saw: it may still come
      if (states_.size() < 2) break;
      contacts_.erase(contact);
      continue;
    }
    if (contact->first > state->first) {  // its contact is lost: answers come in order
      ++lost_;
      ROS_WARN_THROTTLE(1.0, "analysis: %llu steps without their contact",
                        static_cast<unsigned long long>(lost_));
    } else {
      if (state->second->record >= 0)
        for (auto& end : ends_) end.add(*state->second, *contact->second, out);
      contacts_.erase(contact);
    }
    joined_ = state->first + 1;
    states_.erase(state);
  }
  publish(out);
  finishIfDone();
}

void AnalysisNode::finishIfDone() {
  if (!ending_ || finished_ || info_ == nullptr || joined_ <= last_step_) return;
  finished_ = true;
  BlockAnalysis::Output out;
  for (auto& end : ends_) end.finish(out);
  publish(out);
}

void AnalysisNode::publish(const BlockAnalysis::Output& out) {
  for (const auto& point : out.points) point_publisher_.publish(point);
  for (const auto& spectrum : out.spectra) spectrum_publisher_.publish(spectrum);
  for (const auto& block : out.blocks) orbit_publisher_.publish(block);
}

}  // namespace amb_rotor
