# ROS 1 has no authentication: unless two machines are configured explicitly, everything binds to loopback.
if [ -z "${GPR20_ROBOT:-}" ] && [ -z "${GPR20_SERVER:-}" ] && [ -z "${ROS_HOSTNAME:-}" ]; then
    export ROS_IP="${ROS_IP:-127.0.0.1}"
fi
