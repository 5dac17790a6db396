"""``python -m mobility_imu`` is the command line."""

from mobility_imu.cli import main

if __name__ == "__main__":
    main()
