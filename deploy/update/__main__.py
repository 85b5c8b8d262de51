"""Run gpr20-update: python3 FOLDER_OF_THIS_FILE ..."""

from gpr20_update.high.command import main

if __name__ == "__main__":
    main()
