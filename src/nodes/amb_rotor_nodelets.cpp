// The node classes as nodelets: one process, messages are shared pointers.
#include <nodelet/nodelet.h>

#include <pluginlib/class_list_macros.hpp>

#include "amb_rotor/ros/analysis_node.hpp"
#include "amb_rotor/ros/node_setup.hpp"
#include "amb_rotor/ros/orbit_markers.hpp"
#include "amb_rotor/ros/partner_nodes.hpp"
#include "amb_rotor/ros/rotor_plant.hpp"
#include "amb_rotor/ros/validator.hpp"

namespace amb_rotor {

template <class Node>
class NodeletOf : public nodelet::Nodelet {
 private:
  void onInit() override {
    try {
      node_ = std::make_unique<Node>(getNodeHandle(), getPrivateNodeHandle());
    } catch (const InputError& error) {
      NODELET_FATAL("%s", error.what());
      ros::requestShutdown();
    }
  }
  std::unique_ptr<Node> node_;
};

class RotorPlantNodelet : public NodeletOf<RotorPlant> {};
class AmbControllerNodelet : public NodeletOf<AmbController> {};
class AuxiliaryBearingNodelet : public NodeletOf<AuxiliaryBearing> {};
class InjectorNodelet : public NodeletOf<Injector> {};
class AnalysisNodelet : public NodeletOf<AnalysisNode> {};
class OrbitMarkersNodelet : public NodeletOf<OrbitMarkers> {};
class ValidatorNodelet : public NodeletOf<Validator> {};

}  // namespace amb_rotor

PLUGINLIB_EXPORT_CLASS(amb_rotor::RotorPlantNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(amb_rotor::AmbControllerNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(amb_rotor::AuxiliaryBearingNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(amb_rotor::InjectorNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(amb_rotor::AnalysisNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(amb_rotor::OrbitMarkersNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(amb_rotor::ValidatorNodelet, nodelet::Nodelet)
