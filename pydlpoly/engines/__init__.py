"""The engines that compute a scene."""
