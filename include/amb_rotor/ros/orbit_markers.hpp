#pragma once
// Node orbit_markers: what rviz shows, and the tf2 frames. Displacements are scaled to be seen; a text says
// by how much. doc/nodes.md
#include <ros/ros.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>
#include <visualization_msgs/MarkerArray.h>

#include <deque>

#include "amb_rotor/ros/messages.hpp"

namespace amb_rotor {

class OrbitMarkers {
 public:
  OrbitMarkers(const ros::NodeHandle& nodes, const ros::NodeHandle& own);

 private:
  struct TrailPoint {
    double x, y;
    bool contact;
  };
  struct End {
    std::deque<TrailPoint> trail;
    std::deque<SectionPoint> points;
    EndContact contact;
    double x = 0.0, y = 0.0;  ///< of the rotor, absolute [m]
  };

  void takeInfo(const ModelInfo::ConstPtr& info);
  void takeState(const RotorState::ConstPtr& state);
  void draw(const RotorState& state);
  void drawEnd(int end, visualization_msgs::MarkerArray& out) const;
  void drawTrail(int end, visualization_msgs::MarkerArray& out) const;
  void sendFixedFrames();
  void sendFrames(const RotorState& state);
  visualization_msgs::Marker marker(const std::string& name, int id, int type) const;
  double z(int end) const { return info_->aux_z[end]; }

  ros::NodeHandle nodes_;
  double period_, wished_scale_, force_scale_, clearance_shown_, disc_radius_;
  int trail_length_, point_count_;
  double scale_ = 1.0;
  ModelInfo::ConstPtr info_;
  End ends_[2];
  double next_draw_ = 0.0;
  ros::Time stamp_;
  ros::Publisher publisher_;
  ros::Subscriber model_subscriber_, state_subscriber_, contact_subscriber_, point_subscriber_;
  tf2_ros::TransformBroadcaster frames_;
  tf2_ros::StaticTransformBroadcaster fixed_frames_;
};

}  // namespace amb_rotor
